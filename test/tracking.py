"""Performance figures of position control, from true or measured positions."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.control.observer import RestDetector


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
    detector = RestDetector(interval)
    decided = ((detector.push(place), detector.resting) for place in position.tolist())
    resting = [rests for speed, rests in decided if speed is not None]
    return Tracking(
        rms_error=float(np.sqrt(np.mean(error**2))),
        max_error=float(np.abs(error).max()),
        wander=float(np.ptp(position)),
        # A piston that moves from the first sample on has not set off.
        slips=sum(before and not after for before, after in pairwise(resting)),
    )
