"""
Simulation of a hypothesis along a run: restarted at each rest (multiple shooting), or freely.

From rest to rest the model predicts one stick-slip cycle after the other. When the piston slips,
and how far, the residuals of the weak form hardly show.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.diagnosis.balances import Comparison
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.run import Run, positive_mean
from pneu_rig_ros.diagnosis.weak_form import Floats
from pneu_rig_ros.model import along, follow

SETTLING = 0.03
"""From the beginning of a rest to the readings for a restart [s]."""
RESTART_WINDOW = 0.04
"""Length of the readings for a restart [s]."""
BLOCK = 0.029
"""Length of the means that are compared [s]."""
NEAR_ZERO = 2.0
"""A pressure this close to its sensor's zero may be any below it [standard deviations]."""
TOLERANCE = 5e-5
"""Local error of a simulation along a measured motion [-]: 15 Pa at 1.4 MPa."""


@dataclass(frozen=True)
class MultipleShooting:
    """A run whose simulation is restarted from its readings."""

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
        states = np.zeros((count, 4))
        noises = run.noise.pressure_1, run.noise.pressure_2
        for rest in self.run.rests:
            first = rest.first + round(SETTLING / interval)
            last = min(first + round(RESTART_WINDOW / interval), rest.end)
            at = (first + last) // 2
            if rest.first == 0 or not 0 < at < count or last - first < 2:
                continue
            actions[at], begins[at] = follow.RESTART, rest.first * interval
            window = slice(first, last)
            valid = self.run.position_valid[window].all()
            states[at, 0] = run.position[window].mean() if valid else run.stroke
            for i, noise in enumerate(noises):
                slope, offset = np.polyfit(np.arange(last - first), run.pressures[window, i], 1)
                pressure = offset + slope * (at - first)
                known = pressure > run.span.low + NEAR_ZERO * noise
                states[at, 2 + i] = pressure if known else np.nan
        return actions, states, begins

    def simulate(
        self, hypothesis: Hypothesis, free: bool = False, errors: Floats | None = None
    ) -> Floats:
        """
        Return x [m], p1, p2 [Pa] as read if a hypothesis is true, shape (n - 1, 3).

        :param free: whether the simulation is started only once
        :param errors: added to x [m], p1, p2 [Pa] at each restart, shape (n - 1, 3)
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
        gap = np.column_stack([self.run.position, self.run.pressures])[1:] - predicted
        whole = len(gap) // self.block * self.block
        means: Floats = gap[:whole].reshape(-1, self.block, gap.shape[1]).mean(axis=1)
        return means

    @cached_property
    def segments(self) -> NDArray[np.intp]:
        """Number of the restart before each block, shape (blocks,)."""
        actions, _, _ = self.restarts(self.run)
        counts = np.cumsum(actions != 0)
        whole = counts.size // self.block * self.block
        return counts[:whole].reshape(-1, self.block)[:, -1].astype(np.intp)


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
    """Return the modelled force of the bench along the measured motion [N], shape (n - 1,)."""
    force: Floats = -comparison.rates(hypothesis)[:, along.FORCE]
    return force
