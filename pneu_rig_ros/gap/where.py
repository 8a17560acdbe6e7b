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
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter1d
from scipy.signal import savgol_filter

from pneu_rig_ros.analysis.friction import acceleration_zero_phase
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.experiment import Experiment
from pneu_rig_ros.gap.floors import noise_floor
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode, block_means, gap, predict
from pneu_rig_ros.gap.regimes import IN, OUT, REGIMES, block_regimes
from pneu_rig_ros.gap.twin import twin_of
from pneu_rig_ros.model import chambers, friction
from pneu_rig_ros.model.compiled import plain

Floats = NDArray[np.float64]

WINDOW = 17
"""Blocks over which a drift of pressure is a flow."""
SIGNIFICANT = 2.0
"""RMS of a residual in noises from which on a balance disagrees [-]."""
LEAST_BLOCKS = 3
"""Regimes with fewer blocks say nothing."""
SMEARED = 4
"""Blocks on either side of a slide's ends that its residual of forces leaves out."""
GENTLE = 0.5
"""Acceleration above which a slide says little of friction [m/s^2]."""
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
    drift = savgol_filter(difference[:, chamber], WINDOW, 1, deriv=1)
    noise = floor[:, chamber] * share * np.sqrt(12.0 / WINDOW**3)
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
    run = predict(hypothesis, experiment, Mode.FORCES).run
    measured = acceleration_zero_phase(experiment.record.position, experiment.interval)[1:]
    cylinder = hypothesis.model.cylinder
    pressures = (experiment.measured[1:, 2] - run.pressure_1) * cylinder.cap_area - (
        experiment.measured[1:, 3] - run.pressure_2
    ) * cylinder.rod_area
    force = inertia(hypothesis, experiment) * (run.acceleration - measured) + pressures
    values = block_means(force[:, np.newaxis], experiment.block)[:, 0]
    regimes = block_regimes(experiment, cylinder.stroke)
    values = np.where(steady(regimes, block_means(measured[:, np.newaxis], experiment.block)),
                      values, np.nan)  # fmt: skip
    return Residual(
        'force', 'N', values, np.full(values.size, force_noise(hypothesis, experiment))
    )


def inertia(hypothesis: Hypothesis, experiment: Experiment) -> float:
    """Return what is accelerated [kg]: the fluid term of Eq. 9 acts like a mass."""
    model, law = hypothesis.model, hypothesis.model.friction
    fluid: float = law.viscous_coefficient * plain(friction.fluid_time)(law)
    return model.cylinder.moving_mass + experiment.operation.load_mass + fluid


def steady(regimes: NDArray[np.int8], acceleration: Floats) -> NDArray[np.bool_]:
    """
    Return the blocks in which the piston slides and has done so for a while, shape (blocks,).

    The low-pass of the acceleration smears what happens when it breaks away or stops.
    """
    sliding = ((regimes == OUT) | (regimes == IN)) & (np.abs(acceleration[:, 0]) < GENTLE)
    inside: NDArray[np.bool_] = minimum_filter1d(sliding, 2 * SMEARED + 1)
    return inside


def force_noise(hypothesis: Hypothesis, experiment: Experiment) -> float:
    """Return the noise of a block's mean of the force on the sliding piston [N]."""
    cylinder = hypothesis.model.cylinder
    law = hypothesis.model.friction
    of_pressure = np.hypot(
        cylinder.cap_area * experiment.floor[1], cylinder.rod_area * experiment.floor[2]
    )
    span = experiment.block * experiment.interval
    of_speed = law.viscous_coefficient * 2.0 * experiment.floor[0] / span
    of_inertia = inertia(hypothesis, experiment) * 4.0 * experiment.floor[0] / span**2
    return float(np.sqrt(of_pressure**2 + of_speed**2 + of_inertia**2))


def disagreements(hypothesis: Hypothesis, evidence: Evidence) -> list[Disagreement]:
    """Return where a hypothesis disagrees, the most significant first."""
    twins = [twin_of(hypothesis, one, evidence.rng) for one in evidence.experiments]
    measured = tables(hypothesis, evidence.experiments, evidence.rng)
    expected = tables(hypothesis, twins, evidence.rng)
    found = []
    for index in range(len(measured[0][0])):
        for code, name in enumerate(REGIMES):
            floor = _rms(_inside(expected, index, code))
            column = _inside(measured, index, code)
            one = _disagreement(evidence.experiments, column, floor, name)
            found += [one] if one is not None else []
    return sorted(found, key=lambda one: -one.significance)


Table = tuple[list[Residual], NDArray[np.int8]]
"""The residuals of one experiment and the regimes of its blocks."""


def tables(
    hypothesis: Hypothesis, experiments: Sequence[Experiment], rng: np.random.Generator
) -> list[Table]:
    """Return the residuals and regimes of experiments."""
    stroke, found = hypothesis.model.cylinder.stroke, []
    for experiment in experiments:
        floor = noise_floor(hypothesis, experiment, Mode.CHAMBERS, rng)
        every = residuals(hypothesis, experiment, floor)
        found.append((every, block_regimes(experiment, stroke)))
    return found


def _inside(every: Sequence[Table], index: int, code: int) -> list[Residual]:
    """Return one balance of each experiment, NaN outside of a regime."""
    return [
        replace(table[index], values=np.where(regimes == code, table[index].values, np.nan))
        for table, regimes in every
    ]


def _rms(column: Sequence[Residual]) -> float:
    """Return the RMS of some residuals, 0 for none."""
    values = np.concatenate([one.values[np.isfinite(one.values)] for one in column])
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0


def _disagreement(
    experiments: Sequence[Experiment], column: Sequence[Residual], floor: float, regime: str
) -> Disagreement | None:
    """Return the disagreement of one balance in one regime, None within the noise."""
    known = [np.isfinite(one.values) for one in column]
    if sum(int(here.sum()) for here in known) < LEAST_BLOCKS:
        return None
    noises = np.concatenate([one.noise[here] for one, here in zip(column, known, strict=True)])
    noise = max(floor, float(np.sqrt(np.mean(noises**2))))
    rms = _rms(column)
    if rms < SIGNIFICANT * noise:
        return None
    beyond = [np.nan_to_num(np.abs(one.values)) > SIGNIFICANT * noise for one in column]
    spans = _intervals(experiments, beyond)
    bags = tuple(dict.fromkeys(name for name, _, _ in spans))
    first = column[0]
    return Disagreement(
        first.balance, regime, first.unit, rms, noise, bags, tuple(spans[:MOST_INTERVALS])
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
