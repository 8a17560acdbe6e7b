"""The matrix: complete, repeatable, and within what the library can express."""

from collections import Counter
from typing import Any

import pytest

from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.quantity import specifications
from pneu_rig_ros.rig import configuration_from_yaml
from pneu_rig_ros.scenarios.hidden import CYLINDERS, EFFECTS, STRENGTHS, hide, true_parameters

from .fresh import FRESH_PARTS, SYSTEM_PARTS, drawn
from .settings import model_file, settings
from .system import System
from .systems import SYSTEMS, sizes
from .trials import NOISES, PAIRS, PARAMETERS, PARTS, matrix


def test_every_effect_of_the_library_is_hidden_in_turn() -> None:
    causes = {name for name in library.names() if not name.startswith('empirical_')}
    assert set(EFFECTS) == causes
    assert len(EFFECTS) == 42


def test_matrix_is_complete() -> None:
    trials = matrix()
    assert len({trial.key for trial in trials}) == len(trials)
    single = [t for t in trials if t.part == 'single']
    combinations = {(t.names[0], t.cylinder, t.strength, t.noise) for t in single}
    assert len(combinations) == 42 * 3 * 3 * 3 == len(single)
    assert {t.names[0] for t in trials if t.part == 'removed'} == set(EFFECTS)
    assert all(set(t.names) <= set(t.without) for t in trials if t.part == 'removed')
    assert {len(t.names) for t in trials if t.part == 'parameter'} == {1, 2, 3}
    assert Counter(t.part for t in trials).keys() == set(PARTS)


def test_any_first_part_of_the_matrix_is_a_fair_sample() -> None:
    near = [t for t in matrix() if t.noise == NOISES[0]]
    head = Counter(t.part for t in near[: len(near) // 4])
    whole = Counter(t.part for t in near)
    assert all(0.1 < head[part] / whole[part] < 0.5 for part in PARTS)
    assert matrix()[: len(near)] == near


@pytest.mark.parametrize('effect', EFFECTS)
def test_truth_is_within_the_library(effect: str) -> None:
    parameters = library.load(effect).parameters
    wanted: dict[str, Any] = dict(specifications(parameters))
    for cylinder in CYLINDERS:
        friction = settings(cylinder)['friction']
        seen = []
        for strength in STRENGTHS:
            secret = hide(effect, cylinder, strength, friction)
            values = true_parameters(effect, secret, friction)
            # what is not hidden has no effect by default
            assert set(values) | set(parameters._field_defaults) == set(wanted)
            for name, value in values.items():
                wanted[name].check(value, name)
            seen.append(tuple(values.values()))
        assert len(set(seen)) == len(STRENGTHS)


def test_unseen_trials_are_none_of_the_others() -> None:
    unseen = matrix(('unseen',))
    assert len(unseen) == 3 * (len(EFFECTS) + len(PARAMETERS))
    others = {repr(t.secret) for t in matrix(tuple(part for part in PARTS if part != 'unseen'))}
    assert not others & {repr(t.secret) for t in unseen}
    grades = [float(t.strength) for t in unseen if t.strength]
    assert 0.0 <= min(grades) < 0.2
    assert 1.8 < max(grades) <= 2.0


def test_drawn_trials_are_of_all_parts_and_none_was_seen_before() -> None:
    trials = drawn(19)
    assert trials == drawn(19)
    assert len(trials) == len(EFFECTS) + 141
    assert len({trial.key for trial in trials}) == len(trials)
    assert all(trial.key.startswith('fresh/19/') for trial in trials)
    assert {trial.part for trial in trials} == set(FRESH_PARTS)
    nothing = Counter(trial.part for trial in trials if not trial.names)
    assert all(nothing[part] >= 2 for part in (*SYSTEM_PARTS, 'none', 'uncalibrated'))
    others = {repr(t.secret) for t in (*matrix(), *drawn(20)) if t.names}
    assert not others & {repr(t.secret) for t in trials if t.names}
    effects = [t.names[0] for t in trials if t.part == 'single' and t.names and t.noise == 1.0]
    assert set(effects) == set(EFFECTS)
    assert {t.noise for t in trials if t.part == 'none'} == set(NOISES)


def test_drawn_grades_are_spread_over_all_strengths() -> None:
    grades = [float(g) for t in drawn(19) for g in t.strength.split('+') if g]
    assert 0.0 <= min(grades) < 0.2
    assert 1.8 < max(grades) <= 2.0
    assert abs(sum(grades) / len(grades) - 1.0) < 0.2


def test_any_first_part_of_what_is_drawn_is_a_fair_sample() -> None:
    trials = drawn(19)
    head = Counter(t.part in SYSTEM_PARTS for t in trials[: len(trials) // 3])
    whole = Counter(t.part in SYSTEM_PARTS for t in trials)
    assert all(0.2 < head[kind] / whole[kind] < 0.5 for kind in (True, False))


@pytest.mark.parametrize('system', SYSTEMS.values(), ids=SYSTEMS)
def test_what_is_hidden_in_a_system_is_of_the_library(system: System) -> None:
    model = sizes(system, 'any')
    for name in (name for name in system.hidden if '.' not in name):
        wanted: dict[str, Any] = dict(specifications(library.load(name).parameters))
        for grade in (0.0, 2.0):
            values = true_parameters(name, system.hide(name, grade, model), model['friction'])
            for key, value in values.items():
                wanted[key].check(value, name)


def test_pairs_are_of_known_effects_and_differ() -> None:
    assert {name for pair in PAIRS for name in pair} <= set(EFFECTS)
    assert len({frozenset(pair) for pair in PAIRS}) == len(PAIRS) >= 20


def test_wrong_parameters_are_wrong_by_up_to_30_percent_and_loadable() -> None:
    for trial in (t for t in matrix(('parameter', 'unseen')) if '.' in t.names[0]):
        model = settings(trial.cylinder)
        for name, value in trial.secret.truth.items():
            section, key = name.split('.')
            given = model[section][key]
            ratio = value[0] / given[0] if isinstance(given, list) else value / given
            assert 0.003 < abs(ratio - 1.0) <= 0.3
        configuration_from_yaml(model_file(trial.cylinder, trial.secret.truth), trial.key)
