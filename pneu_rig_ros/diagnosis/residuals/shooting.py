"""
Simulation of a hypothesis along a run: restarted at each rest (multiple shooting), or freely.

From rest to rest the model predicts one stick-slip cycle after the other. When the piston slips,
and how far, the residuals of the weak form hardly show. Errors far below the noise add up from
cycle to cycle in a free run, which begins with the readings of its first rest.

As data, the gap of a cycle counts in multiples of its spread, which errors of the readings at the
restart make. A cycle is one piece of data, however many samples it has: a slip at the wrong time
is wrong until the next restart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from pneu_rig_ros.analysis.motion import Rest
from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.measured.reading import positive_mean
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.balances import Comparison
from pneu_rig_ros.diagnosis.residuals.threads import map_runs
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.plant import Trajectory
from pneu_rig_ros.model.run import Impose

SETTLING = 0.03
"""From the beginning of a rest to the readings for a restart [s]."""
RESTART_WINDOW = 0.04
"""Length of the readings for a restart [s]."""
BLOCK = 0.029
"""Length of the means that are compared [s]."""
DRAWS = 8
"""Simulations from other errors of the readings at the restarts."""
NEIGHBOURS = 5
"""Blocks that share the largest spread of them, as a slip may come a little earlier or later."""
ROUNDED = 0.15
"""Share of the noise that remains in any mean: readings may stay within one step [-]."""
NUMERICAL = (2e-5, 3e-5)
"""Errors of the integration, as shares of stroke and of supply pressure [-]."""
CYCLE_WEIGHT = 10.0
"""Independent readings that a cycle is worth."""
SIGNALS = 3.0
"""Position and pressures."""
TRUE_LOSS = 0.35
"""Mean loss of a reading of a true model, at most [-]."""
BROKEN_DOWN = 1e6
"""Gap of a simulation that fails [standard deviations]."""


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

    def restarts(self, run: Run) -> tuple[NDArray[np.int64], Floats, Floats]:
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
        read = readings_of(states)
        zero = np.array([0.0, run.atmospheric_pressure, run.atmospheric_pressure])
        read = zero + np.array(hypothesis.gains) * (read - zero)
        return within_span(read + np.array([hypothesis.position_zero, 0.0, 0.0]), self.run)

    def gap(self, hypothesis: Hypothesis, errors: Floats | None = None) -> Floats:
        """Return measured less predicted x [m], p1, p2 [Pa], block by block, shape (blocks, 3)."""
        predicted = self.simulate(hypothesis, errors=errors)
        gap = np.column_stack([self.run.position, self.run.pressures])[1:] - predicted
        whole = len(gap) // self.block * self.block
        means: Floats = gap[:whole].reshape(-1, self.block, gap.shape[1]).mean(axis=1)
        return means

    @cached_property
    def segments(self) -> NDArray[np.intp]:
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
            counts: Floats = np.where(self.segments < min(len(self.places), 1), 0.0, SIGNALS)
            return counts
        _, inverse, sizes = np.unique(self.segments, return_inverse=True, return_counts=True)
        weights: Floats = CYCLE_WEIGHT / sizes[inverse]
        return weights

    def by_cycle(self, values: Floats) -> Floats:
        """Return the sum of values of the blocks of each cycle, shape (cycles,)."""
        sums = np.bincount(self.segments, values)[np.unique(self.segments)]
        return sums.astype(np.float64)


def readings_of(states: Trajectory) -> Floats:
    """Return x [m], p1, p2 [Pa] as the sensors read them, shape (n, 3)."""
    return np.column_stack(
        [states.position_reading, states.pressure_1_reading, states.pressure_2_reading]
    )


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


@dataclass(frozen=True)
class Cycles:
    """
    Runs with the spread of their simulation.

    :param runs: to be simulated
    :param spreads: standard deviation of the gap of a true model, shape (blocks, 3) each
    """

    runs: tuple[MultipleShooting, ...]
    spreads: tuple[Floats, ...]

    @classmethod
    def of(
        cls,
        hypothesis: Hypothesis,
        comparisons: Sequence[Comparison],
        rng: Generator,
        free: bool = False,
    ) -> Cycles:
        """Return the runs with the spread that they have if the hypothesis is true."""
        runs = tuple(MultipleShooting(comparison, free) for comparison in comparisons)
        spreads = map_runs(partial(spread_of_gap, hypothesis), runs, rng.spawn(len(runs)))
        return cls(runs, tuple(spreads))

    def with_runs(self, comparisons: Sequence[Comparison]) -> Cycles:
        """Return other readings of the same runs, whose spread is the same."""
        runs = tuple(MultipleShooting(comparison, self.free) for comparison in comparisons)
        return Cycles(runs, self.spreads)

    @property
    def free(self) -> bool:
        """Whether the runs are restarted in their first rests alone."""
        return self.runs[0].free

    def residual(self, hypothesis: Hypothesis) -> Floats:
        """Return the vector that a fit minimises: half its square is the sum of the losses."""
        return np.arcsinh(self.gaps(hypothesis)) * self._factors

    def gaps(self, hypothesis: Hypothesis) -> Floats:
        """Return the scaled gaps of all runs, shape (n,)."""
        return np.concatenate([gap.ravel() for gap in self._scaled(hypothesis)])

    def loss_of(self, gaps: Floats) -> float:
        """Return the loss of scaled gaps of all runs [-]."""
        return 0.5 * float(np.sum((np.arcsinh(gaps) * self._factors) ** 2))

    @cached_property
    def _factors(self) -> Floats:
        """Weights of the scaled gaps of all runs in the residual, shape (n,)."""
        weights = np.concatenate([run.weights for run in self.runs])
        return np.repeat(np.sqrt(weights / SIGNALS), int(SIGNALS))

    def losses(self, hypothesis: Hypothesis) -> Floats:
        """Return the loss of each cycle [-], about 2 for a true hypothesis, shape (cycles,)."""
        parts = []
        for run, scaled in zip(self.runs, self._scaled(hypothesis), strict=True):
            parts.append(
                run.by_cycle(0.5 * run.weights * np.mean(np.arcsinh(scaled) ** 2, axis=1))
            )
        return np.concatenate(parts)

    def excess(self, hypothesis: Hypothesis) -> float:
        """
        Return the mean loss of a reading beyond that of a true model [-].

        In free runs one slip may be off and no other: each cycle counts by itself.
        """
        readings = np.concatenate([run.by_cycle(run.weights) for run in self.runs])
        beyond = self.losses(hypothesis) - TRUE_LOSS * readings
        total = np.maximum(beyond, 0.0).sum() if self.free else beyond.sum()
        return max(float(total / readings.sum()), 0.0)

    def losses_by_run(self, hypothesis: Hypothesis) -> Floats:
        """Return the mean loss of the readings of each run [-], shape (runs,)."""
        pairs = zip(self.runs, self._scaled(hypothesis), strict=True)
        return np.array(
            [
                0.5 * np.average(np.mean(np.arcsinh(gap) ** 2, axis=1), weights=run.weights)
                for run, gap in pairs
            ]
        )

    def _scaled(self, hypothesis: Hypothesis) -> list[Floats]:
        """Return the scaled gap of each run, shape (blocks, 3) each."""
        return map_runs(partial(scaled_gap, hypothesis), self.runs, self.spreads)


def scaled_gap(hypothesis: Hypothesis, run: MultipleShooting, spread: Floats) -> Floats:
    """Return the gap of a run in multiples of its spread, shape (blocks, 3)."""
    try:
        scaled = run.gap(hypothesis) / spread
    except RigError:  # the simulation failed
        return np.full(spread.shape, BROKEN_DOWN)
    finite = np.nan_to_num(scaled, nan=BROKEN_DOWN, posinf=BROKEN_DOWN, neginf=-BROKEN_DOWN)
    return np.clip(finite, -BROKEN_DOWN, BROKEN_DOWN)


def spread_of_gap(hypothesis: Hypothesis, shooting: MultipleShooting, rng: Generator) -> Floats:
    """Return the standard deviation of the gap if a hypothesis is true, shape (blocks, 3)."""
    run = shooting.run
    noise = run.noise.readings
    samples = max(round(RESTART_WINDOW / run.interval), 1)
    at_restart = noise * np.hypot(1.0 / np.sqrt(samples), ROUNDED)
    draws = [
        shooting.gap(hypothesis, at_restart * rng.standard_normal((run.size - 1, 3)))
        for _ in range(DRAWS)
    ]
    spread = maximum_filter1d(np.std(draws, axis=0, ddof=1), NEIGHBOURS, axis=0)
    of_mean = noise * np.hypot(1.0 / np.sqrt(shooting.block), ROUNDED)
    stroke, supply = NUMERICAL
    pressure = supply * run.operation.supply_pressure
    numerical = np.array([stroke * run.stroke, pressure, pressure])
    total: Floats = np.sqrt(of_mean**2 + numerical**2 + spread**2)
    return total
