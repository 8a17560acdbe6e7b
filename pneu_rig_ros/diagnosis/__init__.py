"""Diagnosis of a model: where it disagrees with measured runs, why, and a better model."""
