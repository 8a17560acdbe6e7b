"""
Errors that are constant in a run and explain nothing: of the clock, and of the gas at the start.

By how much they change the residuals of each window is found by finite differences. In the noise
they count as one unknown each (``Whitener.with_common``); their values, under a hypothesis, are
those of generalised least squares with the errors' standard deviations as prior knowledge.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from pneu_rig_ros.diagnosis.balances import Comparison, Residuals
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.noise import NoiseModel, noise_model
from pneu_rig_ros.diagnosis.run import Run
from pneu_rig_ros.diagnosis.weak_form import Floats

HALF = 0.5
"""Half the step of the central difference to a clock's offset [standard deviations]."""
ROUNDS = 5
"""Gauss-Newton steps: an offset that is not small against a motion takes three or four."""
SETTLED = 0.01
"""Change of an error that is none any more [standard deviations]."""


@dataclass(frozen=True)
class RunErrors:
    """
    The errors of one run under a hypothesis.

    :param late: delay of the pressures [s]
    :param temperatures: of the gas in both chambers at the start [K]
    :param deviations: standard deviations of the delay [s] and the temperatures [K], shape (3,)
    """

    late: float
    temperatures: tuple[float, float]
    deviations: Floats

    def of(self, run: Run) -> Run:
        """Return a run without its errors."""
        if run.clock_offset > 0.0:
            run = run.with_delay(self.late)
        return replace(run, temperatures=self.temperatures) if run.temperature_offset > 0 else run


def columns(hypothesis: Hypothesis, comparison: Comparison, here: Residuals) -> Residuals:
    """Return the change of each residual by one standard deviation of each error, (m, 3) each."""
    clock = clock_column(hypothesis, comparison)
    starts = start_columns(hypothesis, comparison, here)
    return Residuals(*(np.hstack(pair) for pair in zip(clock, starts, strict=True)))


def clock_column(hypothesis: Hypothesis, comparison: Comparison) -> Residuals:
    """Return the change of each residual by one standard deviation of the delay, (m, 1) each."""
    run = comparison.run
    step = HALF * run.clock_offset
    if step <= 0.0:
        return Residuals(*(np.zeros((size, 1)) for size in _sizes(comparison)))
    early, late = (Comparison(run.with_delay(run.late + side)).residuals(hypothesis)
                   for side in (-step, step))  # fmt: skip
    changes = [(b - a) / (2.0 * HALF) for a, b in zip(early, late, strict=True)]
    return Residuals(*(np.nan_to_num(change)[:, np.newaxis] for change in changes))


def start_columns(hypothesis: Hypothesis, comparison: Comparison, here: Residuals) -> Residuals:
    """
    Return the change of each residual by one standard deviation of the temperatures, (m, 2) each.

    That of one chamber shows in its own balance alone, so that both are changed at once. Without
    an effect nothing depends on it.
    """
    step = comparison.run.temperature_offset
    changes = Residuals(*(np.zeros((size, 2)) for size in _sizes(comparison)))
    if step > 0.0 and hypothesis.effects:
        warm_1, warm_2 = (one + step for one in temperatures_of(hypothesis, comparison.run))
        run = replace(comparison.run, temperatures=(warm_1, warm_2))
        there = Comparison(run).residuals(hypothesis)
        changes.gas_1[:, 0] = np.nan_to_num(there.gas_1 - here.gas_1)
        changes.gas_2[:, 1] = np.nan_to_num(there.gas_2 - here.gas_2)
    return changes


def _sizes(comparison: Comparison) -> tuple[int, int, int, int]:
    gas, motion = comparison.gas.starts.size, comparison.motion.starts.size
    return gas, gas, motion, comparison.ends.size


def temperatures_of(hypothesis: Hypothesis, run: Run) -> tuple[float, float]:
    """Return the temperature of the gas in both chambers at the start of a run [K]."""
    supply = hypothesis.model.gas.supply_temperature
    return run.temperatures or (supply, supply)


def estimated(hypothesis: Hypothesis, comparison: Comparison, noise: NoiseModel) -> RunErrors:
    """
    Return the errors of a run under a hypothesis, each within what its file allows.

    :param noise: without them
    """
    run = comparison.run
    scale = np.array([run.clock_offset, *(run.temperature_offset,) * 2])
    supply = hypothesis.model.gas.supply_temperature
    usual = np.array([0.0, supply, supply])
    most = np.array([run.margin - HALF * run.clock_offset, *(HALF * supply,) * 2])
    found = RunErrors(run.late, temperatures_of(hypothesis, run), scale)
    for _ in range(ROUNDS):
        step, deviations = _step(hypothesis, Comparison(found.of(run)), noise, found, usual, scale)
        before = np.array([found.late, *found.temperatures])
        late, *warm = (usual + np.clip(before + step - usual, -most, most)).tolist()
        found = RunErrors(late, (warm[0], warm[1]), deviations)
        if np.all(np.abs(step) <= SETTLED * scale):
            break
    return found


def _step(
    hypothesis: Hypothesis, comparison: Comparison, noise: NoiseModel, found: RunErrors,
    usual: Floats, scale: Floats,
) -> tuple[Floats, Floats]:  # fmt: skip
    """Return the change of the errors by least squares, and their standard deviations [SI]."""
    here = comparison.residuals(hypothesis)
    slopes = columns(hypothesis, comparison, here)
    off = np.array([found.late, *found.temperatures]) - usual
    off = np.divide(off, scale, out=np.zeros(3), where=scale > 0.0)
    residual = np.concatenate(list(noise.whiten(here)))
    matrix = np.column_stack([np.concatenate(list(noise.whiten(one))) for one in _each(slopes)])
    covariance = np.linalg.inv(matrix.T @ matrix + np.eye(3))
    step = -covariance @ (matrix.T @ residual + off)
    left = residual + matrix @ step
    excess = max(float(left @ left) / max(left.size, 1), 1.0)
    return step * scale, np.sqrt(np.minimum(np.diag(covariance) * excess, 1.0)) * scale


def _each(slopes: Residuals) -> Iterator[Residuals]:
    """Yield the change by each of the errors."""
    for index in range(slopes.gas_1.shape[1]):
        yield Residuals(*(one[:, index] for one in slopes))


def in_time(
    hypothesis: Hypothesis, comparison: Comparison, rng: np.random.Generator
) -> Comparison:
    """
    Return a run with its pressures put right by the delay that they have under a hypothesis.

    About that the residuals are linear in what remains of it.
    """
    if comparison.run.clock_offset <= 0.0:
        return comparison
    noise = noise_model(hypothesis, comparison, rng)
    late = estimated(hypothesis, comparison, noise).late
    return Comparison(comparison.run.with_delay(late))
