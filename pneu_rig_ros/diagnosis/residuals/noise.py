"""
The noise of the residuals under a hypothesis: what the noise of the sensors makes of them.

White noise of the readings passes through the test functions in closed form. Its effect on the
velocity, and so on friction, and the error of smoothing are found by simulated readings: noise is
added to the smoothed run, whose motion is then known exactly.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.random import Generator
from scipy.ndimage import uniform_filter1d

from pneu_rig_ros.arrays import Flags, Floats
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.measured.reading import missed_turns
from pneu_rig_ros.diagnosis.residuals.balances import (
    Comparison,
    Residuals,
    chamber_volume,
    driving_force,
)
from pneu_rig_ros.diagnosis.residuals.weak_form import middles
from pneu_rig_ros.diagnosis.residuals.whitening import Source, Whitener, whitener
from pneu_rig_ros.model import along

COPIES = 8
"""Simulated readings of each run."""
REPLICATE_COPIES = 4
"""The same where noise decides nothing: it only weighs the residuals of a fit to a replicate."""
POOLED = 5
"""Neighbouring windows over which the mean square of their errors is pooled."""
SLOWEST_SLIDE = 0.003
"""
Slower motion is not used [m/s]: seven standard deviations of the velocity, whose error would be
too large on the falling branch of the Stribeck curve.
"""
FORGOTTEN = 10.0
"""Travel after which the bristle has forgotten its start but for e^-10 [F_c/sigma_0]."""
CUT_OFF = float(1.0 / np.sqrt(2.0 * np.pi))
"""Mean of the positive part of normal noise [standard deviations]."""
SAME_BREAKAWAY = 0.15
"""Breakaways of two readings less far apart are the same [s]."""
ONSET = 0.023
"""Error of the time of a breakaway: half the window of the velocity [s]."""
CREEP_ERROR = 0.5
"""Relative error of the speed at which the piston is seen to break away [-]."""
HOLDING_VARIANCE = 0.01
"""Further variance of a breakaway force [N^2]: the seal holds 0.1 N more or less."""


class NoiseModel(NamedTuple):
    """One whitener for each kind of residual of one run."""

    gas_1: Whitener
    gas_2: Whitener
    force: Whitener
    breakaway: Whitener
    stop: Whitener

    def whiten(self, residuals: Residuals) -> Residuals:
        """Return the whitened residuals of the kept windows."""
        return Residuals(*(whiten(each) for whiten, each in zip(self, residuals, strict=True)))

    def with_shared(self, columns: Residuals) -> NoiseModel:
        """Return the noise with more nuisance parameters, see ``Whitener.with_shared``."""
        pairs = zip(self, columns, strict=True)
        return NoiseModel(*(whiten.with_shared(column) for whiten, column in pairs))


def noise_model(
    hypothesis: Hypothesis, comparison: Comparison, rng: Generator, copies: int = COPIES
) -> NoiseModel:
    """
    Return the noise of the residuals of a run if the hypothesis is true.

    :param rng: of the simulated readings
    :param copies: how many of these, see ``COPIES``
    """
    errors = reading_errors(hypothesis, comparison, rng, copies)
    residuals, inertia = comparison.evaluate(hypothesis)
    gas_1, gas_2 = (
        gas_noise(hypothesis, comparison, errors[i], residuals[i], i + 1) for i in (0, 1)
    )
    force = force_noise(hypothesis, comparison, errors.force, residuals.force, inertia)
    breakaway = breakaway_noise(hypothesis, comparison, errors.breakaway, residuals.breakaway)
    return NoiseModel(gas_1, gas_2, force, breakaway, stop_noise(comparison, residuals.stop))


def gas_noise(
    hypothesis: Hypothesis, comparison: Comparison, errors: Floats, residual: Floats, chamber: int
) -> Whitener:
    """
    Return the noise of the balance of a chamber.

    :param errors: of the residuals of simulated readings [kg/s], shape (copies, m)
    :param residual: [kg/s], shape (m,)
    """
    run, gas, name = comparison.run, comparison.gas, f'gas_{chamber}'
    kept = gas.inside(run.pressure_valid(chamber) & run.position_valid)
    kept &= np.isfinite(residual) & (name in run.balances)
    source = Source(gas_variance(hypothesis, comparison, chamber), gas.correlation(gas.slope))
    differs = run.repeatability.get(name, 0.0)
    noise = whitener(kept, [source], excess_variance(errors, source.variance) + differs**2)
    return noise.with_shared(np.full((residual.size, 1), differs))


def force_noise(
    hypothesis: Hypothesis,
    comparison: Comparison,
    errors: Floats,
    residual: Floats,
    inertia: Floats,
) -> Whitener:
    """
    Return the noise of the balance of forces of the sliding piston.

    :param errors: of the residuals of simulated readings [N], shape (copies, m)
    :param residual: [N], shape (m,)
    :param inertia: mean accelerated mass of each window [kg], shape (m,)
    """
    run, motion = comparison.run, comparison.motion
    kept = motion.inside(run.sliding & run.position_valid & ~run.vacuum)
    kept &= np.isfinite(residual) & ('force' in run.balances)
    if run.force is None:
        kept &= np.abs(comparison.window_velocity) > SLOWEST_SLIDE
    else:
        kept &= motion.inside(bristle_is_known(hypothesis, comparison))
    sources = force_sources(hypothesis, comparison, inertia)
    variance = sources[0].variance + sources[1].variance
    offset = np.full((residual.size, 1), run.force_zero_sd)
    differs = run.repeatability.get('force', 0.0)
    excess = excess_variance(errors, variance) + differs**2
    outward = comparison.window_velocity >= 0.0
    levels = np.hypot(differs, run.level_sd) * np.column_stack([outward, ~outward])
    # what smoothing does to a slip, and noise to the bristle of a slow motion, is alike in all
    smeared = np.nan_to_num(errors.mean(axis=0))[:, np.newaxis]
    columns = [clipped_thrust(hypothesis, comparison), offset, levels, smeared]
    return whitener(kept, sources, excess).with_shared(np.hstack(columns))


def excess_variance(errors: Floats, variance: Floats) -> Floats:
    """Return the pooled mean square of errors, shape (copies, m), beyond a variance, (m,)."""
    valid = np.isfinite(errors)
    squares = np.where(valid, errors**2, 0.0).mean(axis=0)
    counts = valid.astype(np.float64).mean(axis=0)
    total, count = (uniform_filter1d(each, POOLED, mode='nearest') for each in (squares, counts))
    mean = np.divide(total, count, out=np.zeros_like(total), where=count > 0.0)
    excess: Floats = np.maximum(mean - variance, 0.0)
    return excess


def gas_variance(hypothesis: Hypothesis, comparison: Comparison, chamber: int) -> Floats:
    """Return the variance of the gas residuals by noise of p and x [kg^2/s^2], shape (m,)."""
    run, windows, gas = comparison.run, comparison.gas, hypothesis.model.gas
    cylinder = hypothesis.model.cylinder
    area = (cylinder.cap_area, cylinder.rod_area)[chamber - 1]
    x, *pressures = middles(run.smooth).T
    volume = chamber_volume(hypothesis, x, chamber)
    k = gas.heat_capacity_ratio
    by_pressure = volume * run.noise.pressures[chamber - 1] / hypothesis.gains[chamber]
    by_position = k * pressures[chamber - 1] * area * run.noise.position / hypothesis.gains[0]
    energy = windows.averages(by_pressure**2 + by_position**2)
    enthalpy = k * gas.gas_constant * gas.supply_temperature
    variance: Floats = energy * float(windows.slope @ windows.slope) / enthalpy**2
    return variance


def force_sources(
    hypothesis: Hypothesis, comparison: Comparison, inertia: Floats
) -> tuple[Source, Source]:
    """
    Return the noise of the force residuals by that of x, and by that of p and the bench.

    :param inertia: accelerated mass in each window [kg], shape (m,)
    """
    run, windows, cylinder = comparison.run, comparison.motion, hypothesis.model.cylinder
    x, p1, p2 = hypothesis.gains
    impulse = np.nan_to_num(inertia) * run.noise.position / x
    by_position = impulse**2 * float(windows.curvature @ windows.curvature)
    white = (cylinder.cap_area * run.noise.pressure_1 / p1) ** 2
    white += (cylinder.rod_area * run.noise.pressure_2 / p2) ** 2 + run.noise.force**2
    by_force = np.full(windows.starts.size, white * float(windows.weights @ windows.weights))
    return (
        Source(by_position, windows.correlation(windows.curvature)),
        Source(by_force, windows.correlation(windows.weights)),
    )


def white_variances(
    hypothesis: Hypothesis, comparison: Comparison, inertia: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return the variances of gas and force residuals by noise of the readings, (m,) each."""
    gas_1, gas_2 = (gas_variance(hypothesis, comparison, chamber) for chamber in (1, 2))
    by_position, by_force = force_sources(hypothesis, comparison, inertia)
    return gas_1, gas_2, by_position.variance + by_force.variance


def bristle_is_known(hypothesis: Hypothesis, comparison: Comparison) -> Flags:
    """
    Return the intervals before which a bench moved the seal far enough, shape (n - 1,).

    By Eq. 10 it forgets its deflection over the travel g/sigma_0, about F_c/sigma_0.
    """
    run, friction = comparison.run, hypothesis.model.friction
    length = friction.coulomb_force / sum(friction.element_stiffness)
    travelled = np.cumsum(np.abs(run.velocity)) * run.interval
    known: Flags = travelled > FORGOTTEN * length
    return known


def clipped_thrust(hypothesis: Hypothesis, comparison: Comparison) -> Floats:
    """
    Return the force error by a pressure that is below the zero of its sensor [N], shape (m, 2).

    The mean of noise that is cut off at zero is 0.4 of its standard deviation.
    """
    run, cylinder = comparison.run, hypothesis.model.cylinder
    clipped = [
        comparison.motion.averages((~run.pressure_valid(chamber)).astype(np.float64))
        for chamber in (1, 2)
    ]
    areas = np.array([cylinder.cap_area, cylinder.rod_area])
    columns: Floats = areas * CUT_OFF * np.array(run.noise.pressures) * np.column_stack(clipped)
    return columns


def breakaway_noise(
    hypothesis: Hypothesis, comparison: Comparison, errors: Floats, residual: Floats
) -> Whitener:
    """Return the noise of the breakaways: that of the readings, and of their time."""
    run, ends = comparison.run, comparison.breakaways
    drive = driving_force(hypothesis, run)
    span = max(round(2.0 * ONSET / run.interval), 1)
    slopes = np.array([(drive[end] - drive[max(end - span, 0)]) / (2.0 * ONSET) for end in ends])
    stiffness = sum(hypothesis.model.friction.element_stiffness)
    creep = slopes / (stiffness * along.FASTEST_CREEP)
    onset = (ONSET * slopes) ** 2 + (CREEP_ERROR * creep * drive[ends]) ** 2
    squares = np.nanmean(np.vstack([errors**2, np.zeros(onset.size)]), axis=0)
    kept = np.isfinite(residual) & ('force' in run.balances) & ~run.vacuum[ends]
    differs = np.hypot(run.repeatability.get('force', 0.0), run.level_sd)
    variance = onset + squares + HOLDING_VARIANCE + differs**2
    return whitener(kept, [Source(variance)], np.zeros(onset.size))


def stop_noise(comparison: Comparison, residual: Floats) -> Whitener:
    """
    Return the noise of the readings at an end stop.

    Readings that stay within one step of the converter, or are cut off at the end of the span, do
    not average out: their mean may be off by as much as a single one.
    """
    run, functions = comparison.run, comparison.stops
    kept = np.isfinite(residual) & functions.inside(run.position_valid)
    kept &= 'force' in run.balances and run.noise.position > 0.0  # else nothing moves
    variance = np.full(residual.size, run.noise.position**2)
    noise = whitener(kept, [Source(variance)], np.zeros(residual.size))
    return noise.with_shared(np.full((residual.size, 1), run.noise.position))


def reading_errors(
    hypothesis: Hypothesis, comparison: Comparison, rng: Generator, count: int
) -> Residuals:
    """Return the errors of the residuals of simulated readings, shape (count, m) each."""
    run, noise = comparison.run, comparison.run.noise
    travelled = np.concatenate([[0.0], np.cumsum(run.velocity)]) * run.interval
    base = run.with_readings(run.smooth[0, 0] + travelled, run.smooth[:, 1:])
    truth = Comparison(run, base).residuals(hypothesis)
    missed = 0.0 if run.force is None else missed_turns(run.position, noise.position)
    scale, place = np.array(noise.pressures), np.hypot(noise.position, missed)
    copies = []
    for _ in range(count):
        position = base.position + place * rng.standard_normal(base.size)
        pressures = base.pressures + scale * rng.standard_normal((base.size, 2))
        force = base.force
        if force is not None:
            force = force + noise.force * rng.standard_normal(base.size)
        copy = Comparison(replace(base, position=position, pressures=pressures, force=force))
        residuals = copy.residuals(hypothesis)
        breakaway = np.full(truth.breakaway.size, np.nan)
        for index, end in enumerate(comparison.breakaways if copy.breakaways.size else ()):
            nearest = int(np.argmin(np.abs(copy.breakaways - end)))
            if abs(copy.breakaways[nearest] - end) * base.interval < SAME_BREAKAWAY:
                breakaway[index] = residuals.breakaway[nearest]
        matched = residuals._replace(breakaway=breakaway)
        copies.append([read - true for read, true in zip(matched, truth, strict=True)])
    return Residuals(*(np.array(column) for column in zip(*copies, strict=True)))
