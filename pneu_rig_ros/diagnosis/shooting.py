"""
A hypothesis simulated along a measured run: started again at every rest, or only once.

From rest to rest the model predicts one stick-slip cycle after the other; what the residuals of
the weak form hardly see - when the piston slips and how far - shows there.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.diagnosis.balances import Comparison
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.run import Run, positive_mean
from pneu_rig_ros.model import along, follow

Floats = NDArray[np.float64]

SETTLING = 0.03
"""From the beginning of a rest to the readings that a restart is made of [s]."""
READING = 0.04
"""Length of the readings that a restart is made of [s]."""
BLOCK = 0.029
"""Length of the means that are compared [s]."""
SATURATED = 2.0
"""A pressure this close to the zero of its sensor may be any below it [noises]."""


@dataclass(frozen=True)
class MultipleShooting:
    """A run with what starts its simulation again."""

    comparison: Comparison

    @property
    def run(self) -> Run:
        """The measured run."""
        return self.comparison.run

    @cached_property
    def block(self) -> int:
        """Samples of the means that are compared."""
        return max(1, round(BLOCK / self.run.interval))

    def restarts(self, run: Run) -> tuple[NDArray[np.int64], Floats, Floats]:
        """
        Return the actions, the measured states and the starts of rest of ``Plant.follow``.

        :param run: the readings, corrected for the errors of the sensors
        """
        count, interval = run.size - 1, run.interval
        actions, begins = np.zeros(count, dtype=np.int64), np.zeros(count)
        measured = np.zeros((count, 4))
        for rest in self.run.rests:
            first = rest.first + round(SETTLING / interval)
            last = min(first + round(READING / interval), rest.end)
            at = (first + last) // 2
            if rest.first == 0 or not 0 < at < count or last - first < 2:
                continue
            actions[at], begins[at] = follow.RESTART, rest.first * interval
            measured[at] = self._reading(run, slice(first, last), at - first)
        return actions, measured, begins

    def _reading(self, run: Run, window: slice, at: int) -> list[float]:
        position = float(run.position[window].mean())
        if not self.run.position_known[window].all():
            position = run.stroke
        noises = run.noise.pressure_1, run.noise.pressure_2
        pressures = [line_at(run.pressures[window, i], at) for i in (0, 1)]
        known = [p if p > run.span.low + SATURATED * noise else np.nan
                 for p, noise in zip(pressures, noises, strict=True)]  # fmt: skip
        return [position, 0.0, *known]

    def simulate(
        self, hypothesis: Hypothesis, free: bool = False, errors: Floats | None = None
    ) -> Floats:
        """
        Return x [m], p1, p2 [Pa] as read if a hypothesis is true, shape (n - 1, 3).

        :param free: whether it is started once only
        :param errors: added to x [m], p1, p2 [Pa] at every restart, shape (n - 1, 3)
        """
        run = self.comparison.corrected(hypothesis)
        plant = hypothesis.plant_of(run)
        actions, measured, begins = self.restarts(run)
        if free:
            actions = np.zeros_like(actions)
        if errors is not None:
            measured[:, [0, 2, 3]] += errors
        states = plant.follow(run.voltages, run.interval, actions, measured, begins)
        read = np.column_stack(
            [states.position_reading, states.pressure_1_reading, states.pressure_2_reading]
        )
        zero = np.array([0.0, run.atmospheric_pressure, run.atmospheric_pressure])
        return within_span(zero + np.array(hypothesis.gains) * (read - zero), self.run)

    def gap(self, hypothesis: Hypothesis, errors: Floats | None = None) -> Floats:
        """Return measured less predicted x [m], p1, p2 [Pa], block by block, shape (blocks, 3)."""
        predicted = self.simulate(hypothesis, errors=errors)
        measured = np.column_stack([self.run.position, self.run.pressures])[1:]
        return block_means(measured - predicted, self.block)

    @cached_property
    def segments(self) -> NDArray[np.intp]:
        """Number of the restart before each block, shape (blocks,)."""
        actions, _, _ = self.restarts(self.run)
        counts = np.cumsum(actions != 0)
        whole = counts.size // self.block * self.block
        return counts[:whole].reshape(-1, self.block)[:, -1].astype(np.intp)


def block_means(signals: Floats, block: int) -> Floats:
    """Return the means over blocks of samples, shape (n // block, columns)."""
    whole = len(signals) // block * block
    means: Floats = signals[:whole].reshape(-1, block, signals.shape[1]).mean(axis=1)
    return means


def within_span(readings: Floats, run: Run) -> Floats:
    """
    Return the mean of readings whose sensors show nothing beyond their span, shape (n, 3).

    Near its ends noise is cut off on one side.
    """
    low = np.array([0.0, run.span.low, run.span.low])
    high = np.array([run.span.position, run.span.high, run.span.high])
    noise = np.array([run.noise.position, run.noise.pressure_1, run.noise.pressure_2])
    above = low + noise * positive_mean((readings - low) / noise)
    with np.errstate(invalid='ignore'):
        below = high - noise * positive_mean((high - above) / noise)
    mean: Floats = np.where(np.isfinite(high), below, above)
    return mean


def line_at(values: Floats, sample: int) -> float:
    """Return the value at a sample of the straight line through some values."""
    slope, offset = np.polyfit(np.arange(values.size), values, 1)
    return float(offset + slope * sample)


TOLERANCE = 5e-5
"""Local error of a run along a measured motion [-]: 15 Pa at 1.4 MPa."""


def chamber_pressures(hypothesis: Hypothesis, comparison: Comparison) -> Floats:
    """Return p1, p2 as read [Pa] along the measured motion, shape (n - 1, 2)."""
    run = comparison.corrected(hypothesis)
    plant = hypothesis.plant_of(run)
    plant.tolerance, plant.longest_step = TOLERANCE, run.interval
    position = np.clip(run.smooth[:, 0], 0.0, run.stroke)
    measured = np.zeros((run.size - 1, 4))
    measured[:, 0], measured[:, 1] = position[:-1], np.diff(position) / run.interval
    actions = np.full(run.size - 1, follow.MOTION, dtype=np.int64)
    states = plant.follow(run.voltages, run.interval, actions, measured, np.zeros(run.size - 1))
    return np.column_stack([states.pressure_1_reading, states.pressure_2_reading])


def bench_force(hypothesis: Hypothesis, comparison: Comparison) -> Floats:
    """Return the force of the bench that moves the piston as measured [N], shape (n - 1,)."""
    force: Floats = -comparison.rates(hypothesis)[:, along.FORCE]
    return force
