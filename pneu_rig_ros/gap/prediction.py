"""What a hypothesis predicts for an experiment, and how far that is from what was measured."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from pneu_rig_ros.gap.experiment import Experiment
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model import follow
from pneu_rig_ros.model.dynamics import DEFLECTION, FILM, VELOCITY
from pneu_rig_ros.model.effect import READING_BALANCES
from pneu_rig_ros.model.plant import Trajectory

Floats = NDArray[np.float64]

HOLD, HOLD_AT_REST = 5, 25
"""Samples over which an imposed velocity is constant, moving and at rest."""


FAR = 9.0
"""Of a reading so many noises above zero nothing is cut off [-]."""
START_NOISE = 3.7
"""Noise of the start, from a few readings at their edge, in that of a restart [-]."""


class Mode(Enum):
    """
    What of the measured run a prediction uses.

    ``CHAMBERS`` imposes the measured motion, so that only gas and valves are predicted, and
    ``FORCES`` too, with the friction of that motion; like ``CYCLES``, which predicts all, they
    start again from the readings at every rest. ``FREE`` has the beginning alone.
    """

    CHAMBERS = 'chambers'
    FORCES = 'forces'
    CYCLES = 'cycles'
    FREE = 'free run'


@dataclass(frozen=True)
class Jitter:
    """
    Errors of the readings that a prediction starts from.

    :param rng: source of the errors
    :param scale: standard deviation of x [m], p1, p2 [Pa]
    """

    rng: np.random.Generator
    scale: Floats

    def draw(self, count: int) -> Floats:
        """Return errors of x, v, p1, p2, shape (count, 4)."""
        errors = np.zeros((count, 4))
        errors[:, [0, 2, 3]] = self.scale * self.rng.standard_normal((count, 3))
        return errors


class Prediction(NamedTuple):
    """
    A predicted run.

    :param readings: x [m], p1, p2 [Pa] as the sensors would show them, shape (n - 1, 3); sample 0
        is the start
    :param run: true states
    """

    readings: Floats
    run: Trajectory


def predict(
    hypothesis: Hypothesis, experiment: Experiment, mode: Mode, jitter: Jitter | None = None
) -> Prediction:
    """
    Return what a hypothesis predicts for an experiment.

    :param jitter: errors of the readings from which it starts and starts again
    """
    experiment, raw = experiment.calibrated(hypothesis.gains), experiment
    no_bias = np.zeros((len(experiment.voltages) + 1, 4))
    bias = no_bias
    if any(library.load(name).balance in READING_BALANCES for name in hypothesis.effects):
        # what the sensors add is found along the measured motion, then taken off what is measured
        rough = _run(hypothesis.forceless(), experiment, Mode.CHAMBERS, no_bias, jitter)
        bias[1:] = _readings(rough) - _true(rough)
        bias[0] = bias[1]
    run = _run(hypothesis, experiment, mode, bias, jitter)
    zero = np.array([0.0, raw.zero, raw.zero])
    readings = zero + np.array(hypothesis.gains) * (_readings(run)[:, [0, 2, 3]] - zero)
    return Prediction(within_span(readings, raw), run)


def within_span(readings: Floats, experiment: Experiment) -> Floats:
    """
    Return the mean of readings whose sensors show nothing beyond their span, shape (n, 3).

    Near its ends noise is cut off on one side.
    """
    zero = np.array([0.0, experiment.zero, experiment.zero])
    sensors, noise = experiment.sensors, np.array(experiment.noise)
    span = np.array([sensors.position_span, sensors.pressure_span, sensors.pressure_span])
    above = zero + _positive_mean(readings - zero, noise)
    mean: Floats = zero + span - _positive_mean(zero + span - above, noise)
    return mean


def _positive_mean(values: Floats, noise: Floats) -> Floats:
    """Return E max(y + n, 0) for values y and normal noise n of a standard deviation."""
    ratio = values / noise
    near = ratio < FAR
    close = ratio[near]
    density = np.exp(-0.5 * close**2) / np.sqrt(2.0 * np.pi)
    ratio[near] = close * ndtr(close) + density
    mean: Floats = noise * ratio
    return mean


def _run(
    hypothesis: Hypothesis, experiment: Experiment, mode: Mode, bias: Floats,
    jitter: Jitter | None,
) -> Trajectory:  # fmt: skip
    start = np.where(_vented(experiment), 0.0, -bias[0])
    stroke = hypothesis.model.cylinder.stroke
    actions, measured, rests = guidance(experiment, mode, bias, stroke)
    if jitter is not None:
        restarts = (actions & follow.RESTART) != 0
        measured[restarts] += jitter.draw(int(restarts.sum()))
        start = start + START_NOISE * jitter.draw(1)[0]
    plant = hypothesis.plant(experiment, start)
    if mode is Mode.CHAMBERS:
        # at each knot the bristle is torn along at another velocity, which the gas does not feel
        plant.follow_roughly(VELOCITY, DEFLECTION, FILM)
    return plant.follow(experiment.voltages, experiment.interval, actions, measured, rests)


def _vented(experiment: Experiment) -> NDArray[np.bool_]:
    """Return which of x, v, p1, p2 begin at the end of a sensor's span: no error of it is seen."""
    start = experiment.operation
    pressures = np.array([start.initial_pressure_1, start.initial_pressure_2])
    return np.concatenate([[False, False], pressures == experiment.zero])


def _readings(run: Trajectory) -> Floats:
    return np.column_stack(
        [run.position_reading, run.velocity_reading, run.pressure_1_reading,
         run.pressure_2_reading]
    )  # fmt: skip


def _true(run: Trajectory) -> Floats:
    return np.column_stack([run.position, run.velocity, run.pressure_1, run.pressure_2])


def guidance(
    experiment: Experiment, mode: Mode, bias: Floats, stroke: float
) -> tuple[NDArray[np.int64], Floats, Floats]:
    """
    Return the actions, the measured states and the starts of rest of ``Plant.follow``.

    :param bias: what the sensors add to x, v, p1, p2 [SI], shape (n, 4)
    :param stroke: where the piston is that its sensor sees no more [m]
    """
    count = len(experiment.voltages)
    actions, begins = np.zeros(count, dtype=np.int64), np.zeros(count)
    measured = experiment.measured[:-1] - bias[:-1]
    if mode is Mode.FREE:
        return actions, measured, begins
    for rest in experiment.rests:
        if 0 < rest.restart < count:
            actions[rest.restart] = follow.RESTART
            begins[rest.restart] = _begin(experiment, rest.start)
            measured[rest.restart] = rest.readings - bias[rest.restart]
            if experiment.beyond_span[rest.restart]:
                measured[rest.restart, 0] = stroke
    if mode in (Mode.CHAMBERS, Mode.FORCES):
        true = experiment.smooth_position - bias[:, 0]
        true = np.where(experiment.beyond_span, stroke, true)
        _impose_motion(experiment, actions, measured, true)
    return actions, measured, begins


def _begin(experiment: Experiment, sample: int) -> float:
    """Return when a rest began [s], before the run for the one that it starts with."""
    return -experiment.operation.rest_time if sample == 0 else sample * experiment.interval


def _impose_motion(
    experiment: Experiment, actions: NDArray[np.int64], measured: Floats, position: Floats
) -> None:
    """Move the piston along straight lines through positions [m], shape (n,)."""
    count = len(actions)
    actions[[rest.end for rest in experiment.rests if rest.end < count]] |= follow.BREAK
    actions[_knots(experiment)] |= follow.MOTION
    actions[actions != 0] |= follow.MOTION
    knots = np.append(np.flatnonzero(actions), count)
    lengths = np.diff(knots) * experiment.interval
    measured[knots[:-1], 0] = position[knots[:-1]]
    measured[knots[:-1], 1] = np.diff(position[knots]) / lengths


def _knots(experiment: Experiment) -> NDArray[np.intp]:
    """Return the samples at which an imposed velocity changes: fewer while the piston rests."""
    every = np.arange(len(experiment.voltages))
    moving = np.ones(every.size, dtype=np.bool_)
    for rest in experiment.rests:
        moving[rest.start + HOLD_AT_REST : max(rest.end - HOLD_AT_REST, 0)] = False
    return np.flatnonzero(every % np.where(moving, HOLD, HOLD_AT_REST) == 0)


def block_means(signals: Floats, block: int) -> Floats:
    """Return the means over blocks of samples, shape (n // block, columns)."""
    whole = len(signals) // block * block
    columns = signals.shape[1]
    means: Floats = signals[:whole].reshape(-1, block, columns).mean(axis=1)
    return means


def gap(hypothesis: Hypothesis, experiment: Experiment, mode: Mode) -> Floats:
    """
    Return measured less predicted, block by block, in SI units.

    Columns x, p1, p2; shape (blocks, 3). A motion that is imposed has no gap: column x is 0.
    """
    predicted = predict(hypothesis, experiment, mode).readings
    measured = experiment.measured[1:, [0, 2, 3]]
    difference = block_means(measured - predicted, experiment.block)
    if mode is Mode.CHAMBERS:
        difference[:, 0] = 0.0
    return difference
