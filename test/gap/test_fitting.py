"""Candidates, fits and the choice among them, each on its own."""

import pickle

import numpy as np
import pytest

from pneu_rig_ros.gap.candidates import (
    Candidate,
    calibration,
    candidates,
    effect_candidate,
    parameter,
    parameters,
)
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.fitting import (
    Explanation,
    Fit,
    first_of_each,
    fit,
    scanned,
    strengthened,
    without_weakest,
)
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode
from pneu_rig_ros.model import effects as library

from .runs import configured, measured

MODEL = configured('cylinder_1').model
GIVEN = Hypothesis(MODEL)
POOL = candidates(GIVEN)


def evidence(mode: Mode, **effects: object) -> Evidence:
    gathered = Evidence([measured(effects=effects)], np.random.default_rng(0))
    gathered.settle_floors(GIVEN, [mode])
    return gathered


@pytest.mark.parametrize('jump', [0.0, 0.3])
def test_an_exhaust_that_is_displaced_keeps_the_shape_of_its_opening(jump: float) -> None:
    valve = MODEL.valve._replace(exhaust_zero_voltage=MODEL.valve.exhaust_voltage + jump)
    given = Hypothesis(MODEL._replace(valve=valve))
    for edge in (2.303, 2.4):
        moved = parameter(given, 'valve.exhaust_voltage', '', ()).apply(given, (edge,))
        shift = edge - valve.exhaust_voltage
        expected = valve._replace(exhaust_voltage=edge)
        zero = moved.model.valve.exhaust_zero_voltage
        assert moved.model.valve == expected._replace(exhaust_zero_voltage=zero)
        assert zero == pytest.approx(valve.exhaust_zero_voltage + shift)
        assert zero >= edge


@pytest.mark.parametrize('candidate', POOL, ids=lambda one: one.name)
def test_what_a_fit_sees_is_the_value(candidate: Candidate) -> None:
    for coordinate, value in zip(candidate.coordinates, candidate.starts[0], strict=True):
        assert coordinate.outward(coordinate.inward(value)) == pytest.approx(value, rel=1e-12)
        low, high = coordinate.bounds
        assert low <= coordinate.inward(value) <= high
        assert coordinate.outward(-1e9) == pytest.approx(coordinate.low)
        assert coordinate.outward(1e9) == pytest.approx(coordinate.high)


def test_every_effect_with_a_name_is_a_candidate_where_the_law_has_room() -> None:
    named = {name for name in library.names() if not library.load(name).describes}
    rungs = {name for name in named if library.load(name).laws}
    assert {one.name for one in POOL if one.is_effect} == named - rungs
    plain = GIVEN.with_parameter('friction', 'model', 2)
    assert 'dwell_static_friction' in {one.name for one in candidates(plain)}
    assert 'inclination' not in {one.name for one in candidates(GIVEN, ['inclination'])}


def test_elements_of_the_bristles_keep_their_shares() -> None:
    stiffness = parameter(GIVEN, 'friction.element_stiffness', 'force', (Mode.CYCLES,))
    old = MODEL.friction.element_stiffness
    changed = stiffness.apply(GIVEN, [2.0 * sum(old)]).model.friction.element_stiffness
    assert changed == pytest.approx([2.0 * item for item in old])


@pytest.mark.parametrize(
    ('name', 'values', 'doubled'),
    [
        ('chamber_leak', (3e-9, 2e-9), (6e-9, 4e-9)),
        ('friction_warm_up', (0.1, 1.5), (0.2, 1.5)),
    ],
)
def test_what_shares_a_unit_is_strengthened_together(
    name: str, values: tuple[float, ...], doubled: tuple[float, ...]
) -> None:
    start = Explanation().plus(effect_candidate(name), values)
    assert strengthened(start, 2.0).values[0] == pytest.approx(doubled)


def test_a_leak_of_both_chambers_shows_its_strength_before_it_is_fitted() -> None:
    areas = library.load('chamber_leak').parameters(5e-10, 1e-9)
    hidden = evidence(Mode.CHAMBERS, chamber_leak=areas)
    start = Explanation().plus(effect_candidate('chamber_leak'), (3e-9, 3e-9))
    cost, best = scanned([start], GIVEN, hidden, [Mode.CHAMBERS])
    assert cost < hidden.cost(GIVEN, [Mode.CHAMBERS]) / 2
    assert best.values[0] == pytest.approx((9e-10, 9e-10), rel=0.4)


@pytest.mark.parametrize(
    ('name', 'truth', 'mode'),
    [
        ('cross_piston_leak', (2e-9,), Mode.CHAMBERS),
        ('inclination', (0.05,), Mode.CYCLES),
    ],
)
def test_a_hidden_strength_is_recovered(name: str, truth: tuple[float, ...], mode: Mode) -> None:
    seen = evidence(mode, **{name: library.load(name).parameters(*truth)})
    part = effect_candidate(name)
    begin = seen.cost(GIVEN, (mode,))
    result = fit(GIVEN, Explanation().plus(part, part.starts[0]), seen, (mode,), 10)
    assert result.cost < 0.5 * begin
    assert result.explanation.values[0] == pytest.approx(truth, rel=0.05)


def test_the_least_significant_parameters_are_taken_out_first() -> None:
    gains = calibration(configured('cylinder_1').sensors)
    assert gains is not None
    explanation, changes = Explanation().plus(gains, gains.starts[0]), (0.3, -0.001, 0.2, 0.002)
    for one, change in zip(parameters(GIVEN), changes, strict=False):
        value = one.coordinates[0].outward(one.coordinates[0].inward(one.was) + change)
        explanation = explanation.plus(one, (value,))
    result = Fit(explanation, 1.0, np.full(7, 0.01))
    names = [part.name for part in explanation.parts]
    left = without_weakest(result, own=1, count=2)
    assert [part.name for part in left.parts] == [names[0], names[1], names[3]]


def test_what_a_worker_sends_back_has_the_same_parts() -> None:
    leak = effect_candidate('chamber_leak')
    there = Explanation().plus(leak, leak.starts[0])
    back = pickle.loads(pickle.dumps(there))
    assert first_of_each([there, back], lambda one: one) == [there]


def test_of_the_same_parts_the_first_values_count_whatever_the_order() -> None:
    leak, heat = effect_candidate('chamber_leak'), effect_candidate('wall_heat_transfer')
    best = Explanation().plus(leak, leak.starts[0]).plus(heat, heat.starts[0])
    worse = Explanation().plus(heat, heat.starts[0]).plus(leak, leak.starts[-1])
    alone = Explanation().plus(leak, leak.starts[0])
    assert first_of_each([best, alone, worse], lambda one: one) == [best, alone]


@pytest.mark.parametrize('name', ['viscous_coefficient', 'dwell_coefficient'])
def test_what_a_law_has_switched_off_is_no_wrong_parameter(name: str) -> None:
    without = GIVEN.with_parameter('friction', name, 0.0)
    names = {one.name for one in parameters(GIVEN)} - {one.name for one in parameters(without)}
    assert names == {f'friction.{name}'}
