"""
Rests and breakaways while the piston moves: the only causal detector.

It is the counterpart of ``motion``, which knows what comes next. At an end stop the piston rests
like anywhere else: no live part asks what holds it.
"""

from __future__ import annotations

from collections import deque

from pneu_rig_ros.analysis.motion import REST_SPEED
from pneu_rig_ros.analysis.velocity import NOISE, WINDOW, window_for

MEAN = 0.05
"""Length of each of the two means with the noise of the rig's sensor [s]."""

MOTION = 3.0
"""A piston faster than this multiple of the speed of rest moves [-]."""


class RestDetector:
    """
    Detects rest and breakaway, sample by sample; the piston counts as resting until it moves.

    The speed is the difference of two successive means of the position. Motion needs three times
    the speed of rest, so that noise ends no rest.

    :param interval: sampling interval [s]
    :param noise: standard deviation of a measured position [m]; with more than the rig's the means
        get longer
    """

    def __init__(self, interval: float, noise: float = NOISE) -> None:
        self.size = max(2, round(MEAN * window_for(interval, noise) / WINDOW / interval))
        self._interval = interval
        self._positions: deque[float] = deque(maxlen=2 * self.size)
        self.reset()

    def reset(self) -> None:
        """Forget all samples."""
        self._positions.clear()
        self._older = self._newer = 0.0
        self.resting = True
        self.broke_away = False
        """Whether a rest ended with the last sample."""

    def push(self, position: float) -> float | None:
        """Take the next position [m]; return the speed [m/s] as soon as both means are full."""
        positions, size = self._positions, self.size
        if len(positions) == 2 * size:
            self._older += positions[size] - positions[0]
            self._newer += position - positions[size]
            positions.append(position)
        else:
            positions.append(position)
            if len(positions) < 2 * size:
                return None
            self._older = sum(list(positions)[:size])
            self._newer = sum(list(positions)[size:])
        rested = self.resting
        speed = abs(self._newer - self._older) / (size * size * self._interval)
        if speed < REST_SPEED:
            self.resting = True
        elif speed > MOTION * REST_SPEED:
            self.resting = False
        self.broke_away = rested and not self.resting
        return speed
