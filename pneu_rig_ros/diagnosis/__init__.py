"""What a model lacks: where it disagrees with measured runs, why, and a better model."""
