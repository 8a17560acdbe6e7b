"""How well a position was controlled, from true or measured positions."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pneu_rig_ros.analysis.friction import Floats
from pneu_rig_ros.control.rest import RestDetector


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
    return Tracking(
        rms_error=float(np.sqrt(np.mean(error**2))),
        max_error=float(np.abs(error).max()),
        wander=float(np.ptp(position)),
        slips=_slips(position, interval),
    )


def _slips(position: Floats, interval: float) -> int:
    """Count how often the piston set off; one that moves already from the first has not."""
    detector = RestDetector(interval)
    decided = ((detector.push(place), detector.resting) for place in position.tolist())
    states = [resting for speed, resting in decided if speed is not None]
    return sum(before and not after for before, after in pairwise(states))
