"""How well a position was controlled, from true or measured positions."""

from typing import NamedTuple

import numpy as np

from pneu_rig_ros.analysis.friction import Floats

REST = 3e-3
"""A piston slower than this rests [m/s]; creep and sensor noise stay below it."""

WINDOW = 0.046
"""Length of the two means of the position whose difference is the speed [s]."""


class Tracking(NamedTuple):
    """
    Figures of a stretch of control.

    :param rms_error: [m]
    :param max_error: largest absolute error [m]
    :param wander: largest less smallest position [m]
    :param slips: how often the piston set off from rest
    """

    rms_error: float
    max_error: float
    wander: float
    slips: int


def tracking(reference: Floats, position: Floats, interval: float) -> Tracking:
    """
    Return the figures of positions [m], shape (n,), against references [m], shape (n,).

    :param interval: sampling interval [s]
    """
    error = reference - position
    lag = max(1, round(WINDOW / interval))
    means = np.convolve(position, np.full(lag, 1.0 / lag), mode='valid')
    speed = np.abs(means[lag:] - means[:-lag]) / (lag * interval)
    moving = speed > REST
    return Tracking(
        rms_error=float(np.sqrt(np.mean(error**2))),
        max_error=float(np.abs(error).max()),
        wander=float(np.ptp(position)),
        slips=int(np.count_nonzero(moving[1:] & ~moving[:-1])),
    )
