"""
Nuisance parameters: what differs from one recording to the next and explains nothing.

The file of a system names them as a list, or as a mapping of names to standard deviations::

    each_recording: [force_offset]
    each_recording: {clock_offset: 0.3 s, initial_temperature: 30 K}

Their effect on the residuals is found by finite differences. The whitening marginalises them
(``Whitener.with_shared``); their values under a hypothesis are those of generalised least squares
with the standard deviations as prior.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator
from scipy.optimize import least_squares

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.balances import (
    Comparison,
    Residuals,
    changes,
    side_by_side,
)
from pneu_rig_ros.diagnosis.residuals.noise import NoiseModel, noise_model
from pneu_rig_ros.diagnosis.residuals.replicates import chamber_pressures
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.quantity import Quantity, mapping_of, read_values
from pneu_rig_ros.rig.configuration import between_recordings

FORCE_OFFSET = 'force_offset'
CLOCK_OFFSET = 'clock_offset'
INITIAL_TEMPERATURE = 'initial_temperature'
HALF_STEP = 0.5
"""Half the step of the central difference to the delay [standard deviations]."""
GAUSS_NEWTON_STEPS = 5
"""At most: a delay that is not small against a motion takes three or four."""
PRESSURE_STEP = 0.01
"""Of the finite differences of simulated pressures [standard deviations]."""
CONVERGED = 0.01
"""Largest last step of a converged estimate [standard deviations]."""


NUISANCES = {
    FORCE_OFFSET: Quantity('N', 1e-3, 1e6, 'zero of the force of a bench'),
    CLOCK_OFFSET: Quantity('s', 1e-4, 10.0, 'delay of the pressures'),
    INITIAL_TEMPERATURE: Quantity(
        'K', 0.1, 100.0, 'of the gas at the start less that of the walls'
    ),
}
"""Errors that are constant in a recording, by their standard deviations."""
USUAL = {
    # more than any force of a bench: its zero is unknown
    FORCE_OFFSET: 1e4,
    # recorders that are started by hand or exchange packets are some 0.1 s apart
    CLOCK_OFFSET: 0.3,
    # filling a chamber, or a stroke in a second, warms or cools its gas by tens of kelvin
    INITIAL_TEMPERATURE: 30.0,
}
"""The same where the file gives none [SI]."""


def read_nuisances(data: object, where: str) -> dict[str, float]:
    """
    Return name -> standard deviation [SI] of the nuisance parameters that a file names.

    :raises RigError: for an unknown name, a wrong unit or a value out of range
    """
    if not isinstance(data, list | dict | None):
        raise RigError(f'{where}: expected a list of names, or a mapping to standard deviations')
    names = mapping_of({str(name): None for name in data or ()}, NUISANCES, where)
    if not isinstance(data, dict):
        return {name: USUAL[name] for name in names}
    return read_values(data, NUISANCES, where)


@dataclass(frozen=True)
class RunNuisances:
    """
    Delay of the pressures [s], and temperatures of the gas in both chambers at the start [K].

    :param values: those of one run, shape (3,) as all of these
    :param deviations: standard deviations of the values
    :param prior: the likeliest values of any run
    :param scale: standard deviations of the prior
    :param limit: largest difference from it
    """

    values: Floats
    deviations: Floats
    prior: Floats
    scale: Floats
    limit: Floats

    @classmethod
    def initial(cls, hypothesis: Hypothesis, run: Run) -> RunNuisances:
        """Return the values for which a run is corrected so far, with deviations of the prior."""
        supply = hypothesis.model.gas.supply_temperature
        values = np.array([run.delay, *initial_temperatures(hypothesis, run)])
        scale = np.array([run.delay_sd, *(run.temperature_sd,) * 2])
        limit = np.array([run.margin - HALF_STEP * run.delay_sd, *(0.5 * supply,) * 2])
        return cls(values, scale, np.array([0.0, supply, supply]), scale, limit)

    @property
    def scaled(self) -> Floats:
        """The values as differences from the prior [standard deviations], shape (3,)."""
        difference = self.values - self.prior
        return np.divide(difference, self.scale, out=np.zeros(3), where=self.scale > 0.0)

    def at(self, scaled: Floats) -> RunNuisances:
        """Return the same with other values, within the limits."""
        inside = np.clip(self.scale * scaled, -self.limit, self.limit)
        return replace(self, values=self.prior + inside)

    def correct(self, run: Run) -> Run:
        """Return a run without these errors."""
        delay, first, second = self.values.tolist()
        if run.delay_sd > 0.0:
            run = run.with_delay(delay)
        return replace(run, temperatures=(first, second)) if run.temperature_sd > 0 else run


def clock_column(hypothesis: Hypothesis, comparison: Comparison) -> Residuals:
    """Return the change of each residual by one standard deviation of the delay, (m, 1) each."""
    run = comparison.run
    step = HALF_STEP * run.delay_sd  # late less early is one standard deviation
    if step <= 0.0:
        return comparison.zeros(1)
    early, late = (
        Comparison(run.with_delay(delay)).residuals(hypothesis)
        for delay in (run.delay - step, run.delay + step)
    )
    return changes(early, late)


def temperature_columns(
    hypothesis: Hypothesis, comparison: Comparison, residuals: Residuals
) -> Residuals:
    """
    Return the change of each residual by one standard deviation of the temperatures, (m, 2) each.

    That of a chamber shows in its own balance alone, so that both are changed at once. Without an
    effect no residual depends on them.
    """
    step = comparison.run.temperature_sd
    columns = comparison.zeros(2)
    if step > 0.0 and hypothesis.effects:
        first, second = initial_temperatures(hypothesis, comparison.run)
        warmer = replace(comparison.run, temperatures=(first + step, second + step))
        change = changes(residuals, Comparison(warmer).residuals(hypothesis))
        columns.gas_1[:, :1], columns.gas_2[:, 1:] = change.gas_1, change.gas_2
    return columns


def varying_columns(hypothesis: Hypothesis, comparison: Comparison) -> Residuals:
    """Return the change of each residual by one standard deviation of what may vary, (m, k)."""
    spreads = between_recordings(comparison.run.repeatability)
    if not spreads:
        return comparison.zeros(0)
    residuals = comparison.residuals(hypothesis)
    moved = (
        comparison.residuals(hypothesis.varied(name, spread)) for name, spread in spreads.items()
    )
    return side_by_side(*(changes(residuals, each) for each in moved))


def initial_temperatures(hypothesis: Hypothesis, run: Run) -> tuple[float, float]:
    """Return the gas temperatures of both chambers when the recording began [K]."""
    supply = hypothesis.model.gas.supply_temperature
    return run.temperatures or (supply, supply)


def estimate_nuisances(
    hypothesis: Hypothesis, comparison: Comparison, noise: NoiseModel
) -> RunNuisances:
    """
    Return the nuisance parameters of a run under a hypothesis, each within its allowed range.

    They are those of generalised least squares with a prior, by Gauss-Newton steps.

    :param noise: without them
    """
    estimate = RunNuisances.initial(hypothesis, comparison.run)
    for _ in range(GAUSS_NEWTON_STEPS):
        scaled = estimate.scaled
        corrected = Comparison(estimate.correct(comparison.run))
        residuals = corrected.residuals(hypothesis)
        temperatures = temperature_columns(hypothesis, corrected, residuals)
        slopes = side_by_side(clock_column(hypothesis, corrected), temperatures)
        columns = [Residuals(*(slope[:, index] for slope in slopes)) for index in range(3)]
        residual = np.concatenate(noise.whiten(residuals))
        matrix = np.column_stack([np.concatenate(noise.whiten(column)) for column in columns])
        # in standard deviations the covariance of the prior is a unit matrix
        covariance = np.linalg.inv(matrix.T @ matrix + np.eye(3))
        step = -covariance @ (matrix.T @ residual + scaled)
        left = residual + matrix @ step
        excess = max(float(left @ left) / max(left.size, 1), 1.0)
        deviations = np.sqrt(np.minimum(np.diag(covariance) * excess, 1.0)) * estimate.scale
        estimate = replace(estimate.at(scaled + step), deviations=deviations)
        if np.all(np.abs(step) <= CONVERGED):
            break
    return estimate


def fitted_to_pressures(
    hypothesis: Hypothesis, comparison: Comparison, start: RunNuisances
) -> RunNuisances:
    """
    Return initial temperatures with which simulated pressures follow the measured ones best.

    Rates hardly show how much gas a closed chamber holds, and so to which pressure it returns: an
    error of 1 K at the start is one of 0.3 % of the pressure ever after. They do show the delay.

    :param start: by the rates
    """
    run, chambers = comparison.run, comparison.run.chambers
    if comparison.free or not chambers or run.temperature_sd <= 0.0:
        return start
    noise, (delay, *temperatures) = np.array(run.noise.pressures), start.scaled

    def estimate(scaled: Floats) -> RunNuisances:
        return start.at(np.append(delay, scaled))

    def residual(scaled: Floats) -> Floats:
        corrected = Comparison(estimate(scaled).correct(run))
        gap = chamber_pressures(hypothesis, corrected) - corrected.run.pressures[1:]
        return np.append((gap[:, chambers] / noise[chambers]).ravel(), scaled)

    def jacobian(scaled: Floats) -> Floats:
        base, steps = residual(scaled), PRESSURE_STEP * np.eye(2)
        return np.column_stack([residual(scaled + step) - base for step in steps]) / PRESSURE_STEP

    solution = least_squares(residual, temperatures, jac=jacobian, max_nfev=GAUSS_NEWTON_STEPS)
    # without the two rows of the prior
    misfit, slopes = np.reshape(solution.fun[:-2], (-1, len(chambers))), solution.jac[:-2]
    excess = max(float(np.mean(misfit**2)), 1.0) * correlated_samples(misfit)
    covariance = np.linalg.inv(slopes.T @ slopes / excess + np.eye(2))
    found = estimate(solution.x)
    # the mass follows from the first pressure: its noise counts as an error of the temperature
    first = found.values[1:] * noise / run.pressures[0]
    deviations = np.hypot(np.sqrt(np.diag(covariance)) * start.scale[1:], first)
    return replace(found, deviations=np.append(start.deviations[0], deviations))


def correlated_samples(values: Floats) -> float:
    """
    Return how many successive samples count as one, from their correlation at lag 1 [-].

    That of an autoregressive process of first order (G. V. Bayley, J. M. Hammersley, Suppl. J. R.
    Stat. Soc. 8 (1946) 184).

    :param values: of one or more series, shape (n, k)
    """
    squares = float(np.sum(values**2))
    lag = float(np.sum(values[1:] * values[:-1])) / squares if squares > 0.0 else 0.0
    inside = min(max(lag, 0.0), 1.0 - 1.0 / values.shape[0])
    return float((1.0 + inside) / (1.0 - inside))


def without_nuisances(
    hypothesis: Hypothesis, comparison: Comparison, rng: Generator
) -> Comparison:
    """
    Return a run corrected for its delay and initial temperatures under a hypothesis.

    The residuals are linear in what remains of them.
    """
    if not comparison.run.has_nuisances:
        return comparison
    noise = noise_model(hypothesis, comparison, rng)
    return Comparison(estimate_nuisances(hypothesis, comparison, noise).correct(comparison.run))
