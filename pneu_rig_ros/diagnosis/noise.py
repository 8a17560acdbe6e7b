"""
What the noise of the sensors makes of the residuals, so that they can be whitened.

White noise of the readings passes through the test functions in closed form. What it does to the
speed, and so to friction, and what smoothing costs, is found by reading again: noise is added to
the smoothed run, whose motion is then known exactly.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky_banded, solve_banded
from scipy.ndimage import uniform_filter1d

from pneu_rig_ros.diagnosis.balances import Comparison, Residuals, driving_force
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.run import Run
from pneu_rig_ros.diagnosis.weak_form import Floats, correlation
from pneu_rig_ros.model import along

Flags = NDArray[np.bool_]

COPIES = 8
"""Readings again of each run."""
POOLED = 5
"""Neighbouring windows whose mean square of the readings again is one."""
FAR = 1e4
"""What a hypothesis that breaks down is off by [standard deviations]."""
NUGGET = 0.02
"""
Share of a variance that is white whatever the test functions say [-]: without it the sum of all
windows, which is the difference of two readings, would be known better than any model is exact.
"""
SAME_EVENT = 0.15
"""Breakaways of two readings less far apart are one [s]."""
ONSET = 0.023
"""Half the window of the speed: so much too early or too late a breakaway may be seen [s]."""


@dataclass(frozen=True)
class Whitener:
    """
    The covariance of one balance's residuals in one run.

    :param kept: windows that say something, shape (m,)
    :param deviation: standard deviation of each kept residual, shape (kept,)
    :param band: Cholesky factor of the covariance of the kept ones, lower banded form
    :param shared: errors that windows have in common, one standard deviation, shape (m, k)
    """

    kept: Flags
    deviation: Floats
    band: Floats
    shared: Floats

    def __call__(self, residual: Floats) -> Floats:
        """Return the residuals as independent numbers of standard deviation 1, shape (kept,)."""
        values = residual[self.kept]
        if not values.size:
            return values
        whitened = self.alone(np.where(np.isfinite(values), values, FAR * self.deviation))
        directions, shrunk = self._common
        both: Floats = whitened - directions @ (shrunk * (directions.T @ whitened))
        return both

    @cached_property
    def _common(self) -> tuple[Floats, Floats]:
        """Directions of the shared errors, whitened, and by how much each is taken back."""
        directions, scale, _ = np.linalg.svd(self.alone(self.shared[self.kept]),
                                             full_matrices=False)  # fmt: skip
        return directions, 1.0 - 1.0 / np.sqrt(1.0 + scale**2)

    def alone(self, values: Floats) -> Floats:
        """Return kept residuals, shape (kept,) or (kept, k), whitened for their own noise."""
        whitened: Floats = solve_banded((self.band.shape[0] - 1, 0), self.band, values)
        return whitened

    def with_common(self, columns: Floats) -> Whitener:
        """
        Return the whitener if windows have errors in common besides.

        :param columns: one standard deviation of each error in all windows, shape (m, k)
        """
        return replace(self, shared=np.hstack([self.shared, columns]))


@dataclass(frozen=True)
class Source:
    """
    Noise of one kind.

    :param variance: of each window, shape (m,)
    :param lags: correlation of windows 1, 2, ... apart [-]
    """

    variance: Floats
    lags: Floats


def whitener(kept: Flags, sources: Sequence[Source], excess: Floats) -> Whitener:
    """
    Return the whitener of a chain of windows.

    :param sources: noise in closed form
    :param excess: variance of what is not correlated, shape (m,)
    """
    where = np.flatnonzero(kept)
    closed = sum((one.variance[where] for one in sources), np.zeros(where.size))
    total, most = closed + excess[where], max((one.lags.size for one in sources), default=0)
    band = np.zeros((most + 1, where.size))
    band[0] = total + NUGGET * closed
    for one in sources:
        own = np.sqrt(one.variance[where])
        for lag, share in enumerate(one.lags, start=1):
            neighbours = where[lag:] - where[:-lag] == lag
            both = share * own[lag:] * own[:-lag]
            band[lag, : max(where.size - lag, 0)] += np.where(neighbours, both, 0.0)
    factor = cholesky_banded(band, lower=True) if where.size else band
    return Whitener(kept, np.sqrt(total), factor, np.zeros((kept.size, 0)))


class NoiseModel(NamedTuple):
    """One whitener a balance, for one run."""

    gas_1: Whitener
    gas_2: Whitener
    force: Whitener
    breakaway: Whitener

    def whiten(self, residuals: Residuals) -> Residuals:
        """Return the whitened residuals of the windows kept."""
        pairs = zip(self, residuals, strict=True)
        return Residuals(*(whiten(residual) for whiten, residual in pairs))

    def with_common(self, columns: Residuals) -> NoiseModel:
        """
        Return the noise if the windows of each balance have errors in common besides.

        :param columns: one standard deviation of each error in all windows, shape (m, k) each
        """
        pairs = zip(self, columns, strict=True)
        return NoiseModel(*(whiten.with_common(column) for whiten, column in pairs))


def noise_model(
    hypothesis: Hypothesis, comparison: Comparison, rng: np.random.Generator
) -> NoiseModel:
    """
    Return the noise of the residuals of a run if the hypothesis is true.

    :param rng: of the readings again
    """
    again = reread(hypothesis, comparison, rng)
    run, gas, motion = comparison.run, comparison.gas, comparison.motion
    rates = comparison.residuals(hypothesis)
    chambers = []
    for chamber in (1, 2):
        variance = gas_variance(hypothesis, comparison, chamber)
        kept = gas.inside(run.pressure_known(chamber) & run.position_known)
        kept &= np.isfinite(rates[chamber - 1]) & (f'gas_{chamber}' in run.balances)
        excess = beyond(again[chamber - 1], variance, kept)
        source = Source(variance, correlation(gas.slope, hop(gas.starts)))
        chambers.append(whitener(kept, [source], excess))
    kept = motion.inside(run.slides & run.position_known) & np.isfinite(rates.force)
    kept &= 'force' in run.balances
    if run.force is None:
        kept &= np.abs(motion.plain_means(run.velocity)) > CREEPS
    sources = force_noise(hypothesis, comparison)
    closed = sum((one.variance for one in sources), np.zeros(kept.size))
    force = whitener(kept, sources, beyond(again.force, closed, kept))
    offset = np.full((motion.starts.size, 1), run.force_offset)
    force = force.with_common(np.hstack([clipped_thrust(hypothesis, comparison), offset]))
    return NoiseModel(
        chambers[0], chambers[1], force, breakaways(hypothesis, comparison, again.breakaway, rates)
    )


def hop(starts: NDArray[np.intp]) -> int:
    """Return the intervals from one window to the next."""
    return int(starts[1] - starts[0]) if starts.size > 1 else 1


def gas_variance(hypothesis: Hypothesis, comparison: Comparison, chamber: int) -> Floats:
    """Return the variance of the gas residuals [kg^2/s^2] by noise of p and x, shape (m,)."""
    run, windows, gas = comparison.run, comparison.gas, hypothesis.model.gas
    cylinder = hypothesis.model.cylinder
    position = 0.5 * (run.smooth[1:, 0] + run.smooth[:-1, 0])
    volume = cylinder.cap_dead_volume + cylinder.cap_area * position
    area = cylinder.cap_area
    if chamber == 2:
        volume = cylinder.rod_dead_volume + cylinder.rod_area * (cylinder.stroke - position)
        area = cylinder.rod_area
    k = gas.heat_capacity_ratio
    pressure = 0.5 * (run.smooth[1:, chamber] + run.smooth[:-1, chamber])
    by_pressure = volume * (run.noise.pressure_1, run.noise.pressure_2)[chamber - 1]
    by_position = k * pressure * area * run.noise.position
    energy = windows.plain_means(by_pressure**2 + by_position**2)
    enthalpy = k * gas.gas_constant * gas.supply_temperature
    variance: Floats = energy * float(windows.slope @ windows.slope) / enthalpy**2
    return variance


def force_noise(hypothesis: Hypothesis, comparison: Comparison) -> list[Source]:
    """Return the noise of the force residuals by white noise of x, and of p and the bench."""
    run, windows, cylinder = comparison.run, comparison.motion, hypothesis.model.cylinder
    inertia = np.nan_to_num(comparison.inertia(hypothesis)) * run.noise.position
    white = (cylinder.cap_area * run.noise.pressure_1) ** 2
    white += (cylinder.rod_area * run.noise.pressure_2) ** 2 + run.noise.force**2
    step = hop(windows.starts)
    mean = np.full(windows.starts.size, white * float(windows.weights @ windows.weights))
    return [
        Source(inertia**2 * float(windows.bend @ windows.bend), correlation(windows.bend, step)),
        Source(mean, correlation(windows.weights, step)),
    ]


def clipped_thrust(hypothesis: Hypothesis, comparison: Comparison) -> Floats:
    """
    Return the force [N] by a pressure that may be any below the zero of its sensor, shape (m, 2).

    The mean of noise that is cut off at zero is 0.4 of it.
    """
    run, cylinder = comparison.run, hypothesis.model.cylinder
    noises = run.noise.pressure_1, run.noise.pressure_2
    columns = [
        area * CUT_OFF * noise
        * comparison.motion.plain_means((~run.pressure_known(chamber)).astype(np.float64))
        for chamber, area, noise in zip((1, 2), (cylinder.cap_area, cylinder.rod_area), noises,
                                        strict=True)
    ]  # fmt: skip
    return np.column_stack(columns)


CREEPS = 0.003
"""
Slower motion says nothing of the force [m/s]: seven standard deviations of the speed, by which it
would be known too badly on the falling branch of the Stribeck curve.
"""
SPEEDS = (0.0, 0.01, 0.03, np.inf)
"""Edges of the speeds between which errors of the force are alike [m/s]."""


def speed_classes(comparison: Comparison) -> NDArray[np.intp]:
    """Return the class of speed and direction of each window of the motion, shape (m,)."""
    velocity = comparison.motion.plain_means(comparison.run.velocity)
    classes = np.digitize(np.abs(velocity), SPEEDS[1:-1])
    return np.where(velocity < 0.0, classes + len(SPEEDS) - 1, classes)


def in_common(classes: NDArray[np.intp], errors: Mapping[int, float]) -> Floats:
    """
    Return the error of the force that all windows of a speed share [N], shape (m, classes).

    :param errors: class -> error
    """
    return np.column_stack([np.where(classes == index, errors.get(index, 0.0), 0.0)
                            for index in range(2 * (len(SPEEDS) - 1))])  # fmt: skip


CUT_OFF = float(1.0 / np.sqrt(2.0 * np.pi))
"""Mean of the positive part of normal noise [standard deviations]."""


def beyond(again: Floats, variance: Floats, kept: Flags) -> Floats:
    """Return the mean square of readings again beyond a variance, pooled, shape (m,)."""
    squares = np.where(np.isfinite(again), again**2, 0.0)
    counts = np.isfinite(again).astype(np.float64)
    total = uniform_filter1d(squares.mean(axis=0), POOLED, mode='nearest')
    share = uniform_filter1d(counts.mean(axis=0), POOLED, mode='nearest')
    mean = np.divide(total, share, out=np.zeros_like(total), where=share > 0.0)
    excess: Floats = np.maximum(mean - variance, 0.0)
    return np.where(kept, excess, 0.0)


def breakaways(
    hypothesis: Hypothesis, comparison: Comparison, again: Floats, residuals: Residuals
) -> Whitener:
    """Return the noise of the breakaways: that of the readings, and of when they are seen."""
    drive, interval = driving_force(hypothesis, comparison.run), comparison.run.interval
    span = max(round(2.0 * ONSET / interval), 1)
    slopes = [(drive[end] - drive[max(end - span, 0)]) / (2.0 * ONSET) for end in comparison.ends]
    stiffness = sum(hypothesis.model.friction.element_stiffness)
    creep = np.array(slopes) / (stiffness * along.FASTEST_CREEP)
    onset = (ONSET * np.array(slopes)) ** 2 + (CREEP_KNOWN * creep * drive[comparison.ends]) ** 2
    squares = np.nanmean(np.vstack([again**2, np.zeros(onset.size)]), axis=0)
    kept = np.isfinite(residuals.breakaway) & ('force' in comparison.run.balances)
    variance = onset + squares + READ * (residuals.breakaway * 0.0 + 1.0)
    return whitener(kept, [Source(variance, np.zeros(0))], np.zeros(onset.size))


CREEP_KNOWN = 0.5
"""The speed at which the piston is seen to break away is known to so much of it [-]."""
READ = 0.01
"""Variance of a breakaway force besides [N^2]: the seal holds 0.1 N more or less."""


def reread(hypothesis: Hypothesis, comparison: Comparison, rng: np.random.Generator) -> Residuals:
    """Return by how much the residuals of readings again are off, shape (COPIES, m) each."""
    run = comparison.run
    travelled = np.concatenate([[0.0], np.cumsum(run.velocity)]) * run.interval
    base = run.read_again(run.smooth[0, 0] + travelled, run.smooth[:, 1:])
    truth = ExactMotion(base, run).residuals(hypothesis)
    copies = [_reread_once(hypothesis, base, truth, comparison, rng) for _ in range(COPIES)]
    return Residuals(*(np.array(column) for column in zip(*copies, strict=True)))


class ExactMotion(Comparison):
    """A run whose velocity and contacts are known: those of another one."""

    def __init__(self, run: Run, motion: Run) -> None:
        """Take the readings of ``run`` and the motion of ``motion``."""
        object.__setattr__(self, 'run', motion)
        object.__setattr__(self, 'base', run)

    def corrected(self, hypothesis: Hypothesis) -> Run:
        """Return the run itself."""
        base: Run = self.__dict__['base']
        return base


def _reread_once(
    hypothesis: Hypothesis, base: Run, truth: Residuals, comparison: Comparison,
    rng: np.random.Generator,
) -> Residuals:  # fmt: skip
    noise = base.noise
    position = base.position + noise.position * rng.standard_normal(base.size)
    scale = np.array([noise.pressure_1, noise.pressure_2])
    pressures = base.pressures + scale * rng.standard_normal((base.size, 2))
    force = base.force
    if force is not None:
        force = force + noise.force * rng.standard_normal(base.size)
    copy = Comparison(replace(base, position=position, pressures=pressures, force=force))
    found = copy.residuals(hypothesis)
    events = np.full(truth.breakaway.size, np.nan)
    for index, end in enumerate(comparison.ends):
        if copy.ends.size:
            nearest = int(np.argmin(np.abs(copy.ends - end)))
            if abs(copy.ends[nearest] - end) * base.interval < SAME_EVENT:
                events[index] = found.breakaway[nearest] - truth.breakaway[index]
    return Residuals(
        found.gas_1 - truth.gas_1, found.gas_2 - truth.gas_2, found.force - truth.force, events
    )
