"""What is said of the cause: intervals, alternatives, the gap that is closed, what to do next."""
