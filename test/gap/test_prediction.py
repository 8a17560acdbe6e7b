"""Predictions along a measured run: what is imposed, what is restarted, what is left alone."""

from dataclasses import replace

import numpy as np
import pytest

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.gap.experiment import Experiment
from pneu_rig_ros.gap.floors import MODEL_SHARE
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import HOLD, HOLD_AT_REST, Mode, guidance, predict
from pneu_rig_ros.gap.twin import twin_of
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model import follow
from pneu_rig_ros.model.dynamics import DEFLECTION, FILM, VELOCITY
from pneu_rig_ros.model.plant import Plant

from .runs import configured, measured

MODEL, MODEL_2 = (configured(f'cylinder_{number}').model for number in (1, 2))


def test_without_actions_it_is_a_run_to_the_last_bit() -> None:
    experiment = measured()
    plant = Plant(MODEL)
    run = plant.run(experiment.voltages, experiment.interval)
    plant.reset()
    count = len(experiment.voltages)
    followed = plant.follow(
        experiment.voltages, experiment.interval, np.zeros(count, dtype=np.int64),
        np.zeros((count, 4)), np.zeros(count),
    )  # fmt: skip
    assert (followed.position == run.position).all()
    assert (followed.pressure_1 == run.pressure_1).all()


def test_effects_that_do_not_act_change_nothing() -> None:
    experiment = measured()
    nulls = {name: library.load(name).null for name in library.names()}
    bare = Plant(MODEL).run(experiment.voltages, experiment.interval)
    full = Plant(MODEL, nulls).run(experiment.voltages, experiment.interval)
    assert (bare.position == full.position).all()


def test_imposed_motion_gives_back_the_pressures() -> None:
    experiment = measured()
    plant = Plant(MODEL, tolerance=1e-7)
    run = plant.run(experiment.voltages, experiment.interval)
    position = np.concatenate([[0.0], run.position])
    count = len(experiment.voltages)
    states = np.zeros((count, 4))
    states[:, 0], states[:, 1] = position[:-1], np.diff(position) / experiment.interval
    plant.reset()
    followed = plant.follow(
        experiment.voltages, experiment.interval, np.full(count, follow.MOTION), states,
        np.zeros(count),
    )  # fmt: skip
    assert np.abs(followed.position - run.position).max() < 1e-9
    assert np.abs(followed.pressure_1 - run.pressure_1).max() < 50.0
    assert np.abs(followed.pressure_2 - run.pressure_2).max() < 50.0


@pytest.mark.parametrize('mode', [Mode.CHAMBERS, Mode.CYCLES])
def test_every_rest_after_the_first_is_restarted_from(mode: Mode) -> None:
    experiment = measured()
    actions, _, _ = guidance(experiment, mode, np.zeros((len(experiment.voltages) + 1, 4)), 0.3)
    restarted = np.flatnonzero(actions & follow.RESTART)
    assert restarted.tolist() == [rest.restart for rest in experiment.rests if rest.restart > 0]
    assert len(restarted) >= 2


def test_a_wrong_start_is_forgotten_at_the_first_rest() -> None:
    # fast strokes: where the piston sticks and slips, a wrong start changes how long it has slid,
    # which the film and an F_s that fades while sliding remember for longer than to the next rest
    experiment = measured(timeline=((0.9, 1.5), (0.0, 1.0)) * 2 + ((0.9, 1.5),))
    shifted = experiment.operation._replace(initial_position=0.02)
    wrong = replace(experiment, operation=shifted)
    truth = Hypothesis(MODEL)
    off = np.abs(predict(truth, wrong, Mode.CYCLES).readings[:, 0] - experiment.measured[1:, 0])
    _, second, third = experiment.rests
    assert off[: second.restart].max() > 0.01
    assert off[second.restart :].max() < 1e-3
    assert third.end < off.size


def test_a_sensor_effect_is_taken_off_what_is_imposed() -> None:
    error = library.load('position_scale').parameters(0.04)
    experiment = measured(effects={'position_scale': error})
    knowing = Hypothesis(MODEL).with_effect('position_scale', error)
    told = (
        predict(knowing, experiment, Mode.CHAMBERS).readings - experiment.measured[1:, [0, 2, 3]]
    )
    naive = predict(Hypothesis(MODEL), experiment, Mode.CHAMBERS).readings
    naive = naive - experiment.measured[1:, [0, 2, 3]]
    assert np.std(told[:, 1]) < 0.5 * np.std(naive[:, 1])


def test_gas_does_not_mind_that_friction_is_not_looked_at() -> None:
    experiment = measured()
    of_gas, of_all = (
        predict(Hypothesis(MODEL), experiment, mode).run for mode in (Mode.CHAMBERS, Mode.FORCES)
    )
    allowed = MODEL_SHARE[1] * experiment.operation.supply_pressure
    assert 0.0 < np.abs(of_gas.pressure_1 - of_all.pressure_1).max() < allowed
    assert 0.0 < np.abs(of_gas.pressure_2 - of_all.pressure_2).max() < allowed
    assert np.abs(of_gas.position - of_all.position).max() < 1e-12


def test_what_is_followed_roughly_takes_fewer_steps() -> None:
    experiment, evaluations = measured(), []
    actions, states, rests = guidance(
        experiment, Mode.FORCES, np.zeros((len(experiment.voltages) + 1, 4)), 0.3
    )
    for rough in ((), (VELOCITY, DEFLECTION, FILM)):
        plant = Plant(MODEL)
        plant.follow_roughly(*rough)
        plant.follow(experiment.voltages, experiment.interval, actions, states, rests)
        evaluations.append(plant.counts['evaluations'])
    assert evaluations[1] < 0.7 * evaluations[0]


def test_a_vented_chamber_is_no_higher_because_its_sensor_shows_nothing_lower() -> None:
    error = library.load('pressure_offset').parameters(0.0, -1500.0)
    experiment = measured(effects={'pressure_offset': error}, timeline=((0.0, 1.5),))
    assert experiment.operation.initial_pressure_2 == experiment.zero
    knowing = Hypothesis(MODEL).with_effect('pressure_offset', error)
    run = predict(knowing, experiment, Mode.CHAMBERS).run
    assert np.abs(run.pressure_2 - experiment.zero).max() < 20.0  # of the noise of the motion


def test_gas_that_is_shut_in_at_the_stop_is_as_warm_as_it_should_be() -> None:
    # errors of the mass of a vented chamber add up while it is open, and show once it is shut
    heat = {'wall_heat_transfer': library.load('wall_heat_transfer').parameters(0.12, 0.15)}
    timeline = ((1.84, 3.0), (0.0, 2.0), (-0.64, 0.5))
    experiment = measured('cylinder_2', heat, timeline=timeline, initial_position=0.15)
    predicted = predict(Hypothesis(MODEL_2, heat), experiment, Mode.FREE).run
    exact = Plant(
        MODEL_2._replace(operation=experiment.operation),
        {**{name: library.load(name).null for name in library.names()}, **heat}, tolerance=1e-10,
    ).run(experiment.voltages, experiment.interval)  # fmt: skip
    assert np.abs(predicted.pressure_1 - exact.pressure_1).max() < 20.0
    assert np.abs(predicted.pressure_2 - exact.pressure_2).max() < 20.0


def test_a_twin_starts_from_the_reading_that_the_run_started_from() -> None:
    experiment, gain = measured(initial_position=0.1), 1.004
    hypothesis = Hypothesis(MODEL, gains=(gain, 1.0, 1.0))
    twin = twin_of(hypothesis, experiment, np.random.default_rng(0))
    assert twin.record.position[:20] == pytest.approx(0.1, abs=6.0 * experiment.noise[0])


@pytest.mark.parametrize('gain', [1.004, 0.996])
def test_a_reading_at_the_end_of_its_span_is_none_also_when_calibrated(gain: float) -> None:
    experiment = measured(initial_position=0.2, timeline=((0.9, 2.5), (-0.6, 1.0)))
    span = experiment.sensors.position_span
    seen = np.minimum(experiment.record.position * gain, span)
    scaled = replace(experiment, record=replace(experiment.record, position=seen))
    calibrated = scaled.calibrated((gain, 1.0, 1.0))
    assert (calibrated.beyond_span == scaled.beyond_span).all()
    assert scaled.beyond_span.any() == (gain > 1.0)


def test_a_short_rest_at_the_start_leaves_the_motion_after_it_as_it_was() -> None:
    experiment = measured(timeline=((0.0, 0.1), (0.9, 1.5)), rest_time=1.0)
    slow = sampled(experiment, 10)
    assert slow.rests[0].end < HOLD_AT_REST
    bias = np.zeros((len(slow.voltages) + 1, 4))
    actions, _, _ = guidance(slow, Mode.CHAMBERS, bias, 0.3)
    knots = np.flatnonzero(actions & follow.MOTION)
    assert np.diff(knots).max() <= HOLD


def sampled(experiment: Experiment, step: int) -> Experiment:
    """Return a run as it would have been sampled so many times as slowly."""
    r = experiment.record
    names = ('position', 'velocity', 'pressure_1', 'pressure_2', 'voltage_1', 'voltage_2',
             'friction', 'arrival_ns')  # fmt: skip
    thinned = {name: getattr(r, name)[::step].copy() for name in names}
    record = replace(r, interval_ns=step * r.interval_ns, **thinned)
    assert record.configuration is not None
    return Experiment.of('slow', record, record.configuration)


@pytest.mark.parametrize(('step', 'reason'), [(20, 'a sample every 23.2 ms'), (10**4, '0.00 s')])
def test_runs_that_are_sampled_too_slowly_or_too_short_are_refused(step: int, reason: str) -> None:
    experiment = measured(timeline=((0.0, 2.0),))
    with pytest.raises(RigError, match=f'slow: {reason}'):
        sampled(experiment, step)
