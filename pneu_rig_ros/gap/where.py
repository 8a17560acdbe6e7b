"""
Where a hypothesis disagrees: the residual of each balance, in its unit, regime by regime.

The balances of gas mass come from the pressures predicted under the measured motion: what of
their drift no predicted flow explains is a flow (Eq. 6)::

    residual = V / (k R T) d(p measured - p predicted)/dt

The balance of forces is Eq. 8 with the measured motion and pressures: the driving force less
friction and inertia as predicted. At rest friction is whatever holds the piston, so it is compared
where the piston slides, and its peaks where it breaks away.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from pneu_rig_ros.analysis.friction import acceleration_zero_phase
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.experiment import Experiment
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode, block_means, gap, predict
from pneu_rig_ros.gap.regimes import IN, OUT, REGIMES, block_regimes
from pneu_rig_ros.model import chambers
from pneu_rig_ros.model.compiled import plain

Floats = NDArray[np.float64]

WINDOW = 7
"""Blocks over which a drift of pressure is a flow."""
SIGNIFICANT = 3.0
"""RMS of a residual in noises from which on a balance disagrees [-]."""
LEAST_BLOCKS = 3
"""Regimes with fewer blocks say nothing."""
BRIDGE = 5
"""Blocks within the noise that do not end an interval of disagreement."""
MOST_INTERVALS = 6
"""Intervals that are told for each disagreement, longest first."""


@dataclass(frozen=True)
class Residual:
    """
    The residual of one balance in one experiment, block by block.

    :param balance: name for a reader
    :param unit: of the residual
    :param values: residual, NaN where the balance says nothing, shape (blocks,)
    :param noise: its standard deviation if the hypothesis is true, shape (blocks,)
    """

    balance: str
    unit: str
    values: Floats
    noise: Floats


@dataclass(frozen=True)
class Disagreement:
    """
    A balance that disagrees significantly in a regime.

    :param rms: of the residual [unit]
    :param noise: root of the mean square of the noise [unit]
    :param bags: names of the experiments
    :param intervals: bag, from, to [s], the longest
    """

    balance: str
    regime: str
    unit: str
    rms: float
    noise: float
    bags: tuple[str, ...]
    intervals: tuple[tuple[str, float, float], ...]

    @property
    def significance(self) -> float:
        """The RMS in noises [-]."""
        return self.rms / self.noise


def residuals(hypothesis: Hypothesis, experiment: Experiment, floor: Floats) -> list[Residual]:
    """
    Return the residuals of all balances in one experiment.

    :param floor: noise floor of the pressures under the measured motion, shape (blocks, 3)
    """
    difference = gap(hypothesis, experiment, Mode.CHAMBERS)
    flows = [mass_residual(hypothesis, experiment, difference, floor, i) for i in (1, 2)]
    return [*flows, force_residual(hypothesis, experiment)]


def mass_residual(
    hypothesis: Hypothesis, experiment: Experiment, difference: Floats, floor: Floats, chamber: int
) -> Residual:
    """Return the residual of the gas mass of chamber 1 or 2 [kg/s]."""
    model, position = hypothesis.model, block_means(experiment.measured[1:], experiment.block)
    between: Any = np.clip(position[:, 0], 0.0, model.cylinder.stroke)
    volumes = plain(chambers.volumes)(between, model.cylinder)
    gas, span = model.gas, experiment.block * experiment.interval
    energy = gas.heat_capacity_ratio * gas.gas_constant * gas.supply_temperature
    share = volumes[chamber - 1] / energy / span
    drift = np.gradient(uniform_filter1d(difference[:, chamber], WINDOW))
    noise = floor[:, chamber] * share / np.sqrt(2.0 * WINDOW)
    drift[_restarted(experiment, drift.size)] = np.nan
    return Residual(f'gas mass {chamber}', 'kg/s', drift * share, noise)


def _restarted(experiment: Experiment, blocks: int) -> NDArray[np.bool_]:
    """Return the blocks whose drift is that of a restart, shape (blocks,)."""
    flags = np.zeros(blocks, dtype=np.bool_)
    for rest in experiment.rests:
        here = rest.restart // experiment.block
        flags[max(0, here - WINDOW // 2 - 1) : here + WINDOW // 2 + 2] = rest.restart > 0
    return flags


def force_residual(hypothesis: Hypothesis, experiment: Experiment) -> Residual:
    """Return the residual of the forces on the sliding piston [N]."""
    run = predict(hypothesis, experiment, Mode.CHAMBERS).run
    model, load = hypothesis.model, experiment.operation.load_mass
    mass = model.cylinder.moving_mass + load
    law = model.friction
    inertia = mass + law.viscous_coefficient * law.fluid_time_constant
    measured = acceleration_zero_phase(experiment.record.position, experiment.interval)[1:]
    cylinder = model.cylinder
    pressures = (experiment.measured[1:, 2] - run.pressure_1) * cylinder.cap_area - (
        experiment.measured[1:, 3] - run.pressure_2
    ) * cylinder.rod_area
    force = inertia * run.acceleration - mass * measured + pressures
    values = block_means(force[:, np.newaxis], experiment.block)[:, 0]
    regimes = block_regimes(experiment, cylinder.stroke)
    values = np.where((regimes == OUT) | (regimes == IN), values, np.nan)
    return Residual(
        'force', 'N', values, np.full(values.size, force_noise(hypothesis, experiment))
    )


def force_noise(hypothesis: Hypothesis, experiment: Experiment) -> float:
    """Return the noise of a block's mean of the force on the sliding piston [N]."""
    cylinder = hypothesis.model.cylinder
    law = hypothesis.model.friction
    of_pressure = np.hypot(
        cylinder.cap_area * experiment.floor[1], cylinder.rod_area * experiment.floor[2]
    )
    span = experiment.block * experiment.interval
    of_speed = law.viscous_coefficient * 2.0 * experiment.floor[0] / span
    mass = hypothesis.model.cylinder.moving_mass + experiment.operation.load_mass
    of_inertia = mass * 4.0 * experiment.floor[0] / span**2
    return float(np.sqrt(of_pressure**2 + of_speed**2 + of_inertia**2))


def disagreements(hypothesis: Hypothesis, evidence: Evidence) -> list[Disagreement]:
    """Return where a hypothesis disagrees, the most significant first."""
    evidence.settle_floors(hypothesis, [Mode.CHAMBERS])
    stroke, found = hypothesis.model.cylinder.stroke, []
    pairs = list(zip(evidence.experiments, evidence.floors[Mode.CHAMBERS], strict=True))
    tables = [residuals(hypothesis, experiment, floor) for experiment, floor in pairs]
    regimes = [block_regimes(experiment, stroke) for experiment in evidence.experiments]
    for index in range(len(tables[0])):
        column = [table[index] for table in tables]
        for code, name in enumerate(REGIMES):
            inside = [regime == code for regime in regimes]
            if (one := _disagreement(evidence.experiments, column, inside, name)) is not None:
                found.append(one)
    return sorted(found, key=lambda one: -one.significance)


def _disagreement(
    experiments: Sequence[Experiment], column: Sequence[Residual],
    inside: Sequence[NDArray[np.bool_]], regime: str,
) -> Disagreement | None:  # fmt: skip
    """Return the disagreement of one balance in one regime, None within the noise."""
    known = [here & np.isfinite(one.values) for one, here in zip(column, inside, strict=True)]
    if sum(int(here.sum()) for here in known) < LEAST_BLOCKS:
        return None
    values = np.concatenate([one.values[here] for one, here in zip(column, known, strict=True)])
    noise = np.concatenate([one.noise[here] for one, here in zip(column, known, strict=True)])
    rms, floor = float(np.sqrt(np.mean(values**2))), float(np.sqrt(np.mean(noise**2)))
    if rms < SIGNIFICANT * floor:
        return None
    beyond = [
        here & (np.abs(one.values) > SIGNIFICANT * one.noise)
        for one, here in zip(column, known, strict=True)
    ]
    spans = _intervals(experiments, beyond)
    bags = tuple(dict.fromkeys(name for name, _, _ in spans))
    first = column[0]
    return Disagreement(
        first.balance, regime, first.unit, rms, floor, bags, tuple(spans[:MOST_INTERVALS])
    )


def _intervals(
    experiments: Sequence[Experiment], beyond: Sequence[NDArray[np.bool_]]
) -> list[tuple[str, float, float]]:
    """Return bag, from, to [s] of the stretches beyond the noise, longest first."""
    spans: list[tuple[str, float, float]] = []
    for experiment, flags in zip(experiments, beyond, strict=True):
        length = experiment.block * experiment.interval
        marks = np.flatnonzero(flags)
        groups = np.split(marks, np.flatnonzero(np.diff(marks) > BRIDGE) + 1)
        spans += [
            (experiment.name, float(group[0] * length), float((group[-1] + 1) * length))
            for group in groups
            if group.size
        ]
    return sorted(spans, key=lambda span: span[1] - span[2])
