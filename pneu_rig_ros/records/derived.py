"""Signals that follow from others: a velocity from positions, valve voltages from the command."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.rig.valve_drive import valve_voltages

Floats = NDArray[np.float64]

VELOCITY_CUTOFF = 32.0
"""Low-pass of a velocity made from positions [Hz], as the rig's own."""


def smoothed_velocity(position: Floats, interval: float) -> Floats:
    """
    Return the velocity [m/s] as the rig's own data acquisition makes it, shape (n,).

    The differentiated position through a first-order low-pass at 32 Hz, without it where the
    sampling is too slow for one.

    :param position: [m], shape (n,)
    :param interval: [s]
    """
    slope = np.diff(position, prepend=position[:1]) / interval
    if VELOCITY_CUTOFF * interval >= 0.45:
        return slope
    warped = np.tan(np.pi * VELOCITY_CUTOFF * interval)
    pole = (1.0 - warped) / (1.0 + warped)
    drive = 0.5 * (1.0 - pole) * (slope + np.concatenate([[0.0], slope[:-1]]))
    return np.array(list(itertools.accumulate(drive.tolist(), lambda v, d: pole * v + d)))


def voltages_of(u: Floats) -> tuple[Floats, Floats]:
    """Return the voltages of valve 1 and 2 [V] by Eq. 1 for commands u [V], shape (n,) each."""
    levels, where = np.unique(u, return_inverse=True)
    pairs = np.array([valve_voltages(float(level)) for level in levels])[where]
    return pairs[:, 0].copy(), pairs[:, 1].copy()
