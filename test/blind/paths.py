"""Motions that are imposed on a piston from outside."""

import numpy as np
from numpy.random import Generator

from .imposed import Path

REST = 2.0
"""Time before a motion begins [s]."""


def waves(stroke: float, random: Generator) -> Path:
    """Return a motion that is the sum of two sines, beginning at rest."""
    amplitudes = stroke * np.array([random.uniform(0.05, 0.12), random.uniform(0.015, 0.06)])
    omegas = 2.0 * np.pi / np.array([random.uniform(5.0, 30.0), random.uniform(1.5, 5.0)])

    def path(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        phase = np.outer(np.maximum(t - REST, 0.0), omegas)
        x = 0.5 * stroke + (np.cos(phase) - 1.0) @ amplitudes
        return x, -(np.sin(phase) * omegas) @ amplitudes

    return path


def steps(stroke: float, duration: float, random: Generator) -> Path:
    """Return a motion from level to level with rests of 3 to 10 s, each step half a cosine."""
    starts = REST + np.concatenate([[0.0], np.cumsum(random.uniform(3.5, 10.0, 100))])
    starts = starts[starts < duration]
    levels = stroke * np.concatenate([[0.5], random.uniform(0.15, 0.85, len(starts))])
    spans = random.uniform(0.3, 1.5, len(starts))

    def path(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x, v = np.full_like(t, levels[0]), np.zeros_like(t)
        for start, span, way in zip(starts, spans, np.diff(levels), strict=True):
            share = np.clip((t - start) / span, 0.0, 1.0)
            x += way * 0.5 * (1.0 - np.cos(np.pi * share))
            v += way * 0.5 * np.pi / span * np.sin(np.pi * share) * ((share > 0) & (share < 1))
        return x, v

    return path


def at_zero(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a piston that does not move, or a vessel that has none."""
    return np.zeros_like(t), np.zeros_like(t)
