"""
Gas of the second plant behind a piston that is moved from outside, valves open or shut.

Classical Runge-Kutta at steps far below all time constants; inputs are held from sample to sample,
as a converter holds them.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

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
