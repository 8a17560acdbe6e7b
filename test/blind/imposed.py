"""
Motions that are imposed on a piston from outside, and the gas behind it, valves open or shut.

Classical Runge-Kutta at steps far below all time constants; inputs are held from sample to sample,
as a converter holds them.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.random import Generator

from . import constants as at
from .gas import gas_rates
from .kept import kept
from .plant import Plant
from .settings import Settings

LONGEST_STEP, SHUT_STEP = 5e-4, 2e-3
"""Of the method, with flow through valves and without [s]."""
CENTRE = 2.5
"""Voltage at which a valve is shut [V]."""
Path = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""Times [s] -> position [m] and velocity [m/s] there."""
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


@kept
def march(
    y: np.ndarray,
    x: np.ndarray,
    v: np.ndarray,
    targets: np.ndarray,
    steps: int,
    step: float,
    c: np.ndarray,
    e: np.ndarray,
) -> np.ndarray:
    """Return the states at the samples, given x and v at every half step."""
    states = np.empty((targets.shape[0] + 1, y.size))
    memory, here = np.zeros(at.ANCHORS), y.copy()
    slopes = np.zeros((4, y.size))
    halves = np.array([0.0, 0.5, 0.5, 1.0])
    states[0], i = y, 0
    for k in range(targets.shape[0]):
        memory[at.TARGET_1], memory[at.TARGET_2] = targets[k, 0], targets[k, 1]
        for _ in range(steps):
            for stage in range(4):
                here[:] = y + halves[stage] * step * slopes[max(stage - 1, 0)]
                place = i + int(2.0 * halves[stage])
                here[at.X], here[at.V] = x[place], v[place]
                gas_rates(here, slopes[stage], memory, c, e)
            y = y + step / 6.0 * (slopes[0] + 2.0 * (slopes[1] + slopes[2]) + slopes[3])
            i += 2
        y[at.X], y[at.V] = x[i], v[i]
        states[k + 1] = y
    return states


def dragged(voltages: np.ndarray, width: float) -> np.ndarray:
    """Return where spools with a play [V] are drawn to by voltages, shape (n, 2)."""
    targets, now = np.empty_like(voltages), np.full(2, CENTRE)
    for k, wanted in enumerate(voltages):
        now = np.clip(now, wanted - 0.5 * width, wanted + 0.5 * width)
        targets[k] = now
    return targets


def gas_run(
    settings: Settings,
    hidden: Mapping[str, float],
    path: Path,
    voltages: np.ndarray,
    interval: float,
    temperature: float | None = None,
) -> np.ndarray:
    """
    Return the states at the samples, shape (n + 1, STATES).

    :param settings: the pressures at the start are those of ``operation``
    :param path: of the piston
    :param voltages: of the valves in each interval [V], shape (n, 2)
    :param temperature: of the gas at the start [K]; that of the supply if not said
    """
    plant = Plant(settings, hidden)
    c, e = plant.c, plant.e
    longest = LONGEST_STEP if np.any(voltages != CENTRE) else SHUT_STEP
    steps = int(np.ceil(interval / longest))
    step = interval / steps
    x, v = path(0.5 * step * np.arange(2 * steps * len(voltages) + 1))
    y = _start(settings['operation'], float(x[0]), temperature or c[at.T_S], c)
    y[at.V] = v[0]
    targets = dragged(voltages, e[at.PLAY])
    return march(y, x, v, targets, steps, step, c, e)


def _start(
    operation: Mapping[str, Any], x: float, temperature: float, c: np.ndarray
) -> np.ndarray:
    y = np.zeros(at.STATES)
    y[at.X], y[at.SPOOL_1], y[at.SPOOL_2] = x, CENTRE, CENTRE
    volumes = c[at.V10] + c[at.A1] * x, c[at.V20] + c[at.A2] * (c[at.STROKE] - x)
    places = (at.P1, at.M1), (at.P2, at.M2)
    for (pressure, mass), volume, number in zip(places, volumes, (1, 2), strict=True):
        y[pressure] = operation[f'initial_pressure_{number}']
        y[mass] = y[pressure] * volume / (c[at.R] * temperature)
    return y
