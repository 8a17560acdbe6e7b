"""Trials in a foreign world: drawn when asked for, judged by mechanism."""

import json
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.answer.verdict import TRUE_ANSWERS
from pneu_rig_ros.scenarios.hidden import CYLINDERS, EFFECTS

from . import foreign_page, foreign_scores
from .__main__ import chosen
from .answers import FOLDER
from .circumstances import AS_STATED, PSI_BY_BAR, WRONG, as_it_is, command_delay, shown, stamps
from .foreign import FORMS, KNOWN, UNKNOWN
from .foreign_page import COUNTED
from .foreign_trials import ALONE, COUNTS, FOREIGN_PARTS, SECOND_PARTS, drawn_foreign, together
from .forms import ALL, ALL_STRENGTHS, mechanism
from .fresh import FRESH, drawn
from .make_trial import find
from .places import balance_of
from .second import SECOND_KNOWN, SECOND_UNKNOWN
from .settings import settings
from .test_scores import answer
from .trials import Trial

DOCS = Path(__file__).parents[2] / 'docs'


def of(part: str) -> list[Trial]:
    return drawn_foreign(19, (part,))


@pytest.mark.parametrize('part', FOREIGN_PARTS)
def test_each_part_has_its_trials_and_is_repeatable(part: str) -> None:
    trials = of(part)
    assert trials == of(part)
    assert len(trials) == COUNTS[part] >= (12 if part in SECOND_PARTS else 60)
    assert len({trial.key for trial in trials}) == len(trials)
    assert {trial.part for trial in trials} == {part}
    assert {trial.cylinder for trial in trials} == set(CYLINDERS)
    assert {trial.key for trial in trials} <= {trial.key for trial in drawn_foreign(19)}


def test_they_are_drawn_only_when_named() -> None:
    assert not {trial.part for trial in drawn(19)} & set(FOREIGN_PARTS)
    assert not [t for t in chosen((FRESH,), 19, (), ()) if t.part in FOREIGN_PARTS]
    assert {t.part for t in chosen(('foreign', 'triples'), 19, (), ())} == {'foreign', 'triples'}


def test_every_form_is_hidden_and_the_right_kind_in_each_part() -> None:
    assert {trial.names[0] for trial in of('foreign')} == set(KNOWN)
    assert {trial.names[0] for trial in of('foreign_unknown')} == set(UNKNOWN)
    assert {trial.names[0] for trial in of('second')} == set(SECOND_KNOWN)
    assert {trial.names[0] for trial in of('second_unknown')} == set(SECOND_UNKNOWN)
    assert {trial.names[0] for trial in of('conditions')} == set(WRONG)
    assert all(not trial.names for trial in of('nuisance_none'))
    causes = {trial.names[0] for trial in of('nuisance')}
    assert causes & set(FORMS)
    assert causes & set(EFFECTS)


def test_strengths_are_within_their_ranges() -> None:
    for trial in [t for part in ALONE for t in of(part)]:
        (name,) = trial.names
        low, high = ALL_STRENGTHS[name][CYLINDERS.index(trial.cylinder)]
        assert low <= trial.secret.effects[name]['strength'] <= high


@pytest.mark.parametrize(('part', 'size'), [('foreign_pairs', 2), ('triples', 3)])
def test_several_forms_are_of_different_mechanisms(part: str, size: int) -> None:
    for trial in of(part):
        assert len(trial.names) == size
        assert together(trial.names)
        words = [word for name in trial.names for word in mechanism(name)]
        assert len(set(words)) == len(words)
    counts = {len({balance_of(name) for name in trial.names}) for trial in of(part)}
    assert counts >= {1, 2}


@pytest.mark.parametrize('part', ['nuisance', 'nuisance_none'])
def test_nuisances_are_weak_and_of_other_mechanisms(part: str) -> None:
    for trial in of(part):
        weak = [name for name in trial.secret.effects if name not in trial.names]
        assert 3 <= len(weak) <= 5
        for name in trial.names:
            if name in FORMS:  # in the stronger half
                low, high = ALL_STRENGTHS[name][CYLINDERS.index(trial.cylinder)]
                assert trial.secret.effects[name]['strength'] >= 0.999 * (low * high) ** 0.5
        for name in weak:
            low = ALL_STRENGTHS[name][CYLINDERS.index(trial.cylinder)][0]
            share = trial.secret.effects[name]['strength'] / low
            assert 0.5 / 3.0 <= share <= 1.5 / 3.0
            if trial.names:
                assert not set(mechanism(name)) & set(mechanism(trial.names[0]))
        assert 0.0 < abs(trial.circumstances.supply - 1.0) <= 0.02
        assert 0.01 <= trial.circumstances.jitter <= 0.03
        assert 288.0 < trial.secret.truth['gas.supply_temperature'] < 304.0


def test_key_finds_its_trial() -> None:
    trial = of('foreign')[3]
    assert find(trial.key) == trial


def test_conditions_are_off_as_drawn() -> None:
    stated = settings('cylinder_1')
    true = as_it_is(stated, AS_STATED._replace(supply=1.03, load=0.9, wear=0.01), 2)
    assert true['operation']['supply_pressure'] == 1.03 * stated['operation']['supply_pressure']
    assert true['operation']['load_mass'] == 0.9 * stated['operation']['load_mass']
    assert true['friction']['coulomb_force'] == 1.02 * stated['friction']['coulomb_force']
    assert as_it_is(stated, AS_STATED, 5) == stated


def test_records_are_exchanged_in_another_unit_or_from_another_zero() -> None:
    true = np.array([[0.1], [3e5], [2e5]])
    assert np.array_equal(shown(true, AS_STATED, 1e5), true)
    changed = AS_STATED._replace(exchanged=True, unit=PSI_BY_BAR, start=0.002)
    x, p1, p2 = shown(true, changed, 1e5)[:, 0]
    assert x == pytest.approx(0.102)
    assert p1 == pytest.approx(1e5 + 6894.757)
    assert p2 == pytest.approx(1e5 + 2.0 * 6894.757)


def test_stamps_jitter_and_samples_are_lost() -> None:
    assert stamps(100, 1_160_000, AS_STATED, 1) is None
    made = stamps(20_000, 1_160_000, AS_STATED._replace(jitter=0.02, lost=0.01), 1)
    assert made is not None
    gaps = np.diff(made.times)
    assert np.all(gaps > 0)
    assert np.std(made.times - 1_160_000 * np.arange(20_000)) == pytest.approx(23_200, rel=0.05)
    assert 0.005 < 1.0 - made.kept.mean() < 0.015
    assert made.times.min() >= 0


@pytest.mark.parametrize('clock', [0.05, -0.05])
def test_clock_that_is_ahead_or_behind_moves_one_of_the_two(clock: float) -> None:
    made = stamps(10, 1_000_000, AS_STATED._replace(clock=clock), 1)
    assert made is not None
    delay = command_delay(AS_STATED._replace(clock=clock))
    assert made.times[0] - delay == round(1e9 * clock)
    assert min(made.times[0], delay) == 0


ANSWERS = [
    answer('foreign', ['woschni_heat'], 'effect', effects=['wall_heat_transfer'], cut=0.95),
    answer(
        'foreign', ['wider_dead_band'], 'parameter', parameters=['valve.intake_voltage'], cut=0.8
    ),
    answer('foreign', ['joined_sleeve'], 'effect', effects=['load_spring'], cut=None),
    answer('foreign', ['joined_sleeve'], 'unknown', visibility=1.0),
    answer('foreign_unknown', ['detent'], 'unknown', balance='force', cut=0.9),
    answer('foreign_unknown', ['compressor_pulsation'], 'unknown', balance='force', cut=0.2),
    answer('foreign_unknown', ['churning'], 'effect', effects=['load_spring'], cut=0.1),
    answer('nuisance', ['supply_droop'], 'effect', effects=['supply_droop']),
    answer('nuisance_none', [], 'uncalibrated'),
    answer('nuisance_none', [], 'parameter', parameters=['friction.coulomb_force']),
    answer('conditions', ['supply_pressure'], 'conditions', conditions=['supply_pressure']),
    answer('conditions', ['load_mass'], 'effect', effects=['inclination']),
    answer(
        'foreign_pairs',
        ['tapered_tube', 'linear_seal_leak'],
        'effect',
        effects=['chamber_leak', 'position_dependent_friction'],
        least_visibility=5.0,
    ),
    answer(
        'foreign_pairs',
        ['tapered_tube', 'linear_seal_leak'],
        'effect',
        effects=['chamber_leak'],
        least_visibility=1.0,
    ),
    answer(
        'triples',
        ['tapered_tube', 'linear_seal_leak', 'line_volume'],
        'effect',
        effects=['chamber_leak', 'position_dependent_friction'],
        least_visibility=5.0,
    ),
    answer('second', ['pressed_slit_leak'], 'effect', effects=['porous_leak'], cut=0.97),
    answer('second', ['darcy_line'], 'effect', effects=['valve_lag'], cut=0.6),
    answer('second', ['darcy_line'], 'effect', effects=['valve_lag'], visibility=1.0),
    answer('second_unknown', ['side_volume'], 'unknown', balance='gas', cut=0.1),
    answer('second_unknown', ['holding_magnet'], 'unknown', balance='gas', cut=0.1),
    answer('second_unknown', ['warming_coil'], 'effect', effects=['valve_lag'], cut=0.1),
]
EXPECTED = {
    'foreign_mechanism': (2 / 3, 3),
    'foreign_cut': (0.8, 3),
    'foreign_unknown': (2 / 3, 3),
    'foreign_balance': (0.5, 2),
    'unknown_cut': (0.2, 3),
    'unknown_least_cut': (0.1, 3),
    'nuisance_cause': (1.0, 1),
    'nuisance_alarm': (0.5, 2),
    'conditions_named': (0.5, 2),
    'foreign_pairs_both': (1.0, 1),
    'triples_all': (0.0, 1),
    'second_mechanism': (0.5, 2),
    'second_cut': (pytest.approx(0.785), 2),
    'second_unknown': (2 / 3, 3),
    'second_balance': (0.5, 2),
}


def test_figures_are_those_of_the_answers() -> None:
    figures = foreign_scores.figures(ANSWERS)
    found = {name: (figure['value'], figure['trials']) for name, figure in figures.items()}
    assert found == EXPECTED
    assert set(foreign_scores.WANTED) == set(figures)
    assert foreign_scores.figures([])['unknown_least_cut']['value'] is None


def test_form_that_the_library_has_since_is_not_foreign_any_more() -> None:
    since = foreign_scores.MATCHED['spring_behind_gap']
    seeds = since - 1, since
    one = answer('foreign', ['spring_behind_gap'], 'effect', cut=1.0, ranking=['load_spring'])
    before, after = ({**one, 'key': f'fresh/{seed}/foreign/-'} for seed in seeds)
    assert foreign_scores.foreign_seen([before, after], 'foreign') == [before]


def test_tables_have_a_row_for_each_figure_and_form() -> None:
    text = foreign_scores.headline(ANSWERS)
    assert text.count('\n| `') == len(foreign_scores.WANTED)
    rows = foreign_scores.by_form(ANSWERS)
    heat = ', '.join(ALL['woschni_heat'].mechanism)
    assert f'| `woschni_heat` | gas | {heat} | 1 of 1 | wall_heat_transfer |' in rows
    assert '| `detent` | force | - | 1 of 1 | unknown |' in rows
    assert '| `compressor_pulsation` | gas | - | 0 of 1 | unknown |' in rows
    assert '| `darcy_line` | gas | line_lag, line_resistance | 0 of 1 | valve_lag |' in rows
    assert '| `side_volume` | gas | - | 1 of 1 | unknown |' in rows
    worth = foreign_scores.by_verdict(ANSWERS)
    for row in (
        '`conditions` | 1 of 1',
        '`effect` | 6 of 12',
        '`parameter` | 1 of 2',
        '`uncalibrated` | 1 of 1',
        '`unknown` | 4 of 5',
    ):
        assert f'| {row} |' in worth


def test_wrong_answers_have_a_kind_and_right_ones_a_draw() -> None:
    drawn_from = [{**each, 'key': f'fresh/{60 + n % 2}/-'} for n, each in enumerate(ANSWERS)]
    kinds = foreign_page.by_kind(drawn_from)
    for row in (
        '`foreign` | another cause, no gap on the held-out recordings | 1 of 3 | `joined_sleeve`',
        '`foreign_unknown` | another cause, which closes less than 90 % of the gap | 1 of 3 | '
        '`churning`',
        '`conditions` | another cause, no gap on the held-out recordings | 1 of 2 | `load_mass`',
    ):
        assert f'| {row} |' in kinds
    assert kinds.count('\n| `') == 7
    by_seed = foreign_page.by_draw({'abc': drawn_from}).splitlines()
    assert by_seed[2].startswith('| 60 | abc | 1 of 2 |')
    assert by_seed[3].startswith('| 61 | abc | 1 of 1 |')


def test_page_is_written_of_the_answers_kept(tmp_path: Path) -> None:
    """Of all draws, each with its revision; figures go into a file of their own."""
    (tmp_path / FOLDER).mkdir()
    trial = drawn_foreign(60, ('foreign',))[0]
    mine = answer('foreign', list(trial.names), 'unknown', cut=0.5, ranking=['stribeck'])
    other = {**mine, 'key': 'fresh/61/foreign/-'}
    early = {**mine, 'key': 'fresh/60/nuisance/-', 'part': 'nuisance'}
    for revision, one in (('abc', {**mine, 'key': trial.key}), ('def', other), ('ghi', early)):
        store = tmp_path / FOLDER / f'{revision}_foreign.jsonl'
        store.write_text(json.dumps(one) + '\n')
    foreign_page.write_kept(tmp_path / FOLDER, tmp_path)
    page = (tmp_path / 'blind_foreign.md').read_text()
    assert f'| `{trial.key}` |' in page
    assert '| 60 | abc | 0 of 1 |' in page
    assert '| 61 | def | 0 of 1 |' in page
    assert '| `foreign` | 2 | 168 | 2 |' in page
    figures = json.loads((tmp_path / 'blind_foreign.json').read_text())
    assert figures['foreign_mechanism']['trials'] == 2
    assert figures['draws'][1:] == [{'seed': 61, 'revision': 'def'}]
    assert figures['nuisance_cause']['trials'] == 0


def test_nothing_of_a_foreign_form_is_in_the_package() -> None:
    laws = [f'{of}{kind}' for of in ('foreign', 'second') for kind in ('', '_gas', '_force')]
    for name in (*laws, 'foreign_sensors', 'second_sensors', 'forms', 'circumstances'):
        assert 'pneu_rig_ros' not in Path(__file__).with_name(f'{name}.py').read_text()


def test_calibration_error_is_that_of_the_stated_shares() -> None:
    right, wrong = ANSWERS[0], ANSWERS[2]
    assert foreign_scores.by_probability(ANSWERS)[1] is None
    sure = [{**right, 'probability': 0.97}] * 3 + [{**wrong, 'probability': 0.97}]
    table, error = foreign_scores.by_probability([*sure, {**wrong, 'probability': 0.3}])
    assert error == pytest.approx(0.8 * 0.22 + 0.2 * 0.3)
    assert '| 0.80 to 1.00 | 0.97 | 3 of 4 | 75 % |' in table
    assert '| 0.20 to 0.40 | 0.30 | 0 of 1 | 0 % |' in table


def test_stated_shares_are_those_of_the_answers_so_far() -> None:
    """What an answer says of its verdict is what was counted in like systems."""
    stores = foreign_page.kept_answers(DOCS / FOLDER).values()
    kept = [
        (each['verdict'], each['part'].startswith('nuisance'), foreign_scores.right(each))
        for found in stores
        for each in found
        if foreign_scores.seed_of(each) in COUNTED
    ]
    for key, (true, count) in TRUE_ANSWERS.items():
        own = [is_true for *of, is_true in kept if tuple(of) == key]
        assert (sum(own), len(own)) == (true, count)


def test_refusal_names_the_cylinder_or_counts_as_a_miss() -> None:
    line = 'run: position from 0 to 0.3 m, cylinder_3 allows -0.05 to 0.25 m; is it {}?'
    answer = {'verdict': 'refused', 'names': ['cylinder'], 'cylinder': 'cylinder_1'}
    assert foreign_scores.condition_named({**answer, 'error': line.format('that of cylinder_1')})
    assert not foreign_scores.condition_named({**answer, 'error': line.format('in another unit')})
    assert not foreign_scores.condition_named(
        {**answer, 'names': ['load_mass'], 'error': 'of cylinder_1'}
    )
