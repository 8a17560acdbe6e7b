"""Strokes over a grid of conditions and parameters."""
