"""What a run lacks in each balance under a hypothesis, its noise, and where it is significant."""
