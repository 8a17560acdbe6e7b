"""
The true regimes of a simulated run, from states that no sensor sees.

The definitions of ``analysis.regimes``, sample by sample, with the plant's own velocity, friction
force or bristle deflection, and contact. Nothing is smoothed, nothing of the analysis is used.
"""

from itertools import groupby
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.model.plant import Trajectory

DWELL, PRESLIDING, BREAKAWAY, SLIDING, END_STOP = range(5)

REST_SPEED, LEAST_REST, INTERVAL = 1e-3, 0.06, 1.16e-3


class Truth(NamedTuple):
    regime: NDArray[np.int64]
    slips: int


def true_cycles(run: Trajectory, rest_speed: float = REST_SPEED) -> list[float]:
    """Return the dwell [s] of each stick-slip cycle, from the plant's own velocity."""
    feed, dwell, dwells = true_feed(run), 0.0, []
    slow = np.abs(run.velocity) < rest_speed
    for rests, samples in groupby(range(slow.size), key=slow.__getitem__):
        stretch = np.array(list(samples))
        if rests and stretch.size * INTERVAL >= LEAST_REST:
            dwell += stretch.size * INTERVAL
        elif dwell and np.abs(run.velocity[stretch]).max() > max(feed, rest_speed):
            dwells.append(dwell)
            dwell = 0.0
    return dwells


def true_feed(run: Trajectory) -> float:
    """Return the mean speed [m/s] farther than 0.5 mm from both ends of the travel."""
    x = run.position
    under_way = (x > x.min() + 5e-4) & (x < x.max() - 5e-4)
    return float(np.abs(run.velocity[under_way]).mean()) if np.ptp(x) > 1e-3 else np.inf


def true_regimes(run: Trajectory, load: NDArray[np.float64]) -> Truth:
    """
    Return the true regimes and the number of slips.

    :param load: what has its peak at breakaway: the plant's friction force, or the deflection of
        the bristles, which let go then
    """
    feed, load = true_feed(run), np.abs(load)
    regime = np.where(run.contact != 0, END_STOP, DWELL)
    speed = np.abs(run.velocity)
    moves = (speed > feed / 2) & (run.contact == 0)
    slips = 0
    for moving, samples in groupby(range(moves.size), key=moves.__getitem__):
        stretch = np.array(list(samples))
        if not moving or speed[stretch].max() <= feed:
            continue  # creep that never gets as fast as the feed is part of the dwell
        fast = stretch[speed[stretch] > 1.4 * feed]
        slips += bool(fast.size)
        onset = fast[0] if fast.size else stretch[0]
        way = np.cumsum(speed[stretch])
        if way[onset - stretch[0]] > way[-1] / 2:
            onset = stretch[0]  # it glides farther than it slips
        before = stretch[stretch <= onset]
        peak = before[load[before].argmax()]
        regime[stretch] = np.select(
            [stretch >= onset, stretch >= peak], [SLIDING, BREAKAWAY], PRESLIDING
        )
    return Truth(regime, slips)
