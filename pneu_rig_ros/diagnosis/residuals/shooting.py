"""
Simulation of a hypothesis along a run: restarted at each rest (multiple shooting), or freely.

From rest to rest the model predicts one stick-slip cycle after the other. When the piston slips,
and how far, the residuals of the weak form hardly show. Errors far below the noise add up from
cycle to cycle in a free run, which begins with the readings of its first rest.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pneu_rig_ros.analysis.motion import Rest
from pneu_rig_ros.arrays import Floats, Indices, Integers
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.measured.reading import positive_mean
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.balances import Comparison
from pneu_rig_ros.diagnosis.residuals.replicates import as_read, readings_of
from pneu_rig_ros.model.run import Impose

SETTLING = 0.03
"""From the beginning of a rest to the readings for a restart [s]."""
RESTART_WINDOW = 0.04
"""Length of the readings for a restart [s]."""
BLOCK = 0.029
"""Length of the means that are compared [s]."""
CYCLE_WEIGHT = 10.0
"""Independent readings that a cycle is worth."""
SIGNALS = 3
"""Position and pressures."""


@dataclass(frozen=True)
class MultipleShooting:
    """
    A run whose simulation is restarted from its readings.

    :param free: whether that is done in its first rest alone
    """

    comparison: Comparison
    free: bool = False

    @property
    def run(self) -> Run:
        """The measured run."""
        return self.comparison.run

    @cached_property
    def block(self) -> int:
        """Samples of the means that are compared."""
        return max(1, round(BLOCK / self.run.interval))

    @cached_property
    def places(self) -> list[tuple[Rest, slice, int]]:
        """Rests from whose readings the run may be restarted, those readings, and the sample."""
        places, interval = [], self.run.interval
        for rest in self.run.rests:
            first = rest.first + round(SETTLING / interval)
            last = min(first + round(RESTART_WINDOW / interval), rest.end)
            at = (first + last) // 2
            if (rest.first or self.free) and 0 < at < self.run.size - 1 and last - first >= 2:
                places.append((rest, slice(first, last), at))
        return places

    def restarts(self, run: Run) -> tuple[Integers, Floats, Floats]:
        """
        Return the actions, the measured states and the starts of rest of ``Plant.run_imposed``.

        :param run: the readings, corrected for the errors of the sensors
        """
        count, interval = run.size - 1, run.interval
        actions, begins = np.zeros(count, dtype=np.int64), np.zeros(count)
        states = np.zeros((count, 4))
        for rest, window, at in self.places[:1] if self.free else self.places:
            held = Impose.STOP if self.run.sides[at] else 0
            actions[at], begins[at] = Impose.RESTART | held, rest.first * interval
            valid = self.run.position_valid[window].all()
            states[at, 0] = run.position[window].mean() if valid else run.stroke
            for chamber in (1, 2):
                readings = run.pressures[window, chamber - 1]
                slope, offset = np.polyfit(np.arange(readings.size), readings, 1)
                pressure = offset + slope * (at - window.start)
                unknown = run.near_zero(chamber, pressure)
                states[at, 1 + chamber] = np.nan if unknown else pressure
        return actions, states, begins

    def simulate(
        self, hypothesis: Hypothesis, free: bool = False, errors: Floats | None = None
    ) -> Floats:
        """
        Return x [m], p1, p2 [Pa] as read if a hypothesis is true, shape (n - 1, 3).

        :param free: whether the simulation is started only once
        :param errors: added to x [m], p1, p2 [Pa] at each restart, shape (n - 1, 3)
        """
        run = self.comparison.corrected(hypothesis)[0]
        plant = hypothesis.plant_of(run)
        actions, measured, begins = self.restarts(run)
        if free:
            actions = np.zeros_like(actions)
        if errors is not None:
            measured[:, [0, 2, 3]] += errors
        voltages = hypothesis.voltages(run)
        states = plant.run_imposed(voltages, run.interval, actions, measured, begins)
        return within_span(as_read(hypothesis, run, readings_of(states)), self.run)

    def gap(self, hypothesis: Hypothesis, errors: Floats | None = None) -> Floats:
        """Return measured less predicted x [m], p1, p2 [Pa], block by block, shape (blocks, 3)."""
        predicted = self.simulate(hypothesis, errors=errors)
        gap = np.column_stack([self.run.position, self.run.pressures])[1:] - predicted
        whole = len(gap) // self.block * self.block
        means: Floats = gap[:whole].reshape(-1, self.block, gap.shape[1]).mean(axis=1)
        return means

    @cached_property
    def segments(self) -> Indices:
        """Number of the cycle of each block, shape (blocks,)."""
        begins = np.array([at for _, _, at in self.places])
        ends = self.block * np.arange(1, (self.run.size - 1) // self.block + 1)
        return np.searchsorted(begins, ends - 1, side='right').astype(np.intp)

    @cached_property
    def weights(self) -> Floats:
        """
        Independent readings that each block is worth, shape (blocks,).

        In a free run of a true model nothing but the noise of the means is left, each of which is
        a reading; what is before its start is none.
        """
        if self.free:
            return np.where(self.segments < min(len(self.places), 1), 0.0, float(SIGNALS))
        _, inverse, sizes = np.unique(self.segments, return_inverse=True, return_counts=True)
        weights: Floats = CYCLE_WEIGHT / sizes[inverse]
        return weights

    def by_cycle(self, values: Floats) -> Floats:
        """Return the sum of values of the blocks of each cycle, shape (cycles,)."""
        sums = np.bincount(self.segments, values)[np.unique(self.segments)]
        return sums.astype(np.float64)


def within_span(readings: Floats, run: Run) -> Floats:
    """
    Return the mean of readings whose sensors show nothing beyond their span, shape (n, 3).

    Near its ends noise is cut off on one side.
    """
    low = np.array([0.0, run.span.low, run.span.low])
    high = np.array([run.span.position, run.span.high, run.span.high])
    noise = run.noise.readings
    above = low + noise * positive_mean((readings - low) / noise)
    with np.errstate(invalid='ignore'):
        below = high - noise * positive_mean((high - above) / noise)
    mean: Floats = np.where(np.isfinite(high), below, above)
    return mean
