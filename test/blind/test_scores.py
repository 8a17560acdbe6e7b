"""The judges, on answers written by hand."""

import json
from pathlib import Path
from typing import Any

import pytest

from pneu_rig_ros.scenarios.hidden import EFFECTS

from . import foreign_scores, page, page_tables, scores
from .answers import FOLDER, joined
from .confusion import confusion
from .figures import DIGITS
from .fresh import drawn
from .trials import matrix

ROOT = Path(__file__).resolve().parents[2]
NO_TIME = {'true': 0.0, 'told': 0.0, 'shared': 0.0}


def answer(part: str, names: list[str], verdict: str, **more: Any) -> dict[str, Any]:
    """Return an answer as it is kept."""
    base = {
        'key': f'{part}/{"+".join(names)}/{verdict}', 'part': part, 'cylinder': 'cylinder_1',
        'noise': 1.0, 'strength': '1.00', 'names': names, 'visibility': 50.0,
        'verdict': verdict, 'error': '', 'ranking': [], 'effects': [], 'parameters': [],
        'conditions': [], 'alike': [], 'balance': '', 'where': [], 'times': NO_TIME,
        'null_scores': [],
        'before': 9.0, 'after': 1.0, 'cut': None, 'errors': {}, 'covered': {}, 'seconds': 60.0,
        'workers': 2, 'revision': 'x',
    }  # fmt: skip
    return {**base, **more}


def score(balance: str, regime: str, mean: float, rms: float, count: int) -> dict[str, Any]:
    return {'balance': balance, 'regime': regime, 'mean': mean, 'rms': rms, 'count': count}


def times(true: float, told: float, both: float) -> dict[str, float]:
    return {'true': true, 'told': told, 'shared': both}


ANSWERS = [
    answer('single', ['stribeck'], 'effect', ranking=['stribeck'], effects=['stribeck'], cut=0.9,
           errors={'stribeck.excess': 0.02, 'stribeck.stribeck_velocity': 0.2},
           covered={'stribeck.excess': True, 'stribeck.stribeck_velocity': False},
           where=['force', 'gas_1'], times=times(4.0, 4.0, 3.0), seconds=4.0),
    answer('single', ['valve_lag'], 'effect', ranking=['line_lag', 'valve_lag'],
           effects=['line_lag'], alike=[['line_lag', 'valve_lag']], cut=0.7,
           where=['gas_2'], times=times(2.0, 0.0, 0.0), seconds=5.0),
    answer('single', ['inclination'], 'parameter', parameters=['friction.coulomb_force'], cut=0.1,
           where=['gas_1'], times=times(1.0, 2.0, 1.0), seconds=6.0),
    answer('single', ['load_spring'], 'consistent', visibility=1.0),
    answer('single', ['load_spring'], 'effect', effects=['load_spring'], noise=10.0),
    answer('none', [], 'consistent', null_scores=[score('gas_1', 'dwell', 0.5, 1.0, 100)]),
    answer('none', [], 'consistent', null_scores=[score('gas_1', 'dwell', -0.1, 2.0, 300)]),
    answer('none', [], 'effect', ranking=['inclination'], effects=['inclination'],
           where=['force'], workers=1),
    answer('parameter', ['friction.coulomb_force'], 'parameter',
           ranking=['friction.coulomb_force'], parameters=['friction.coulomb_force']),
    answer('parameter', ['friction.coulomb_force'], 'effect', effects=['inclination'],
           where=['force']),
    answer('pair', ['supply_droop', 'inclination'], 'effect', where=['gas_1'],
           ranking=['inclination'], effects=['inclination', 'supply_droop']),
    answer('pair', ['supply_droop', 'inclination'], 'effect', where=['gas_1'],
           ranking=['inclination'], effects=['inclination']),
    answer('removed', ['supply_droop'], 'unknown', balance='gas_1', where=['gas_1']),
    answer('removed', ['inclination'], 'unknown', balance='gas_2', where=['gas_2']),
    answer('removed', ['stribeck'], 'effect', ranking=['inclination'], effects=['inclination'],
           where=['force']),
    answer('uncalibrated', ['stribeck'], 'effect', effects=['stribeck']),
    answer('uncalibrated', [], 'consistent'),
    answer('uncalibrated', [], 'uncalibrated', where=['gas_1']),
    answer('uncalibrated', [], 'parameter', parameters=['friction.coulomb_force']),
    answer('sealed_chambers', ['position_scale'], 'effect', effects=['position_scale'],
           where=['gas_2'], covered={'position_scale.error': True}),
    answer('seal_bench', [], 'uncalibrated', where=['force']),
]  # fmt: skip


def test_figures_count_what_is_right_and_visible() -> None:
    found = {name: (f['value'], f['trials']) for name, f in scores.figures(ANSWERS).items()}
    assert found == {
        'single_top1': (1 / 3, 3),
        'false_alarm': (1 / 3, 3),
        'parameter_top1': (0.5, 2),
        'pairs_both': (0.5, 2),
        'triples_all': (None, 0),
        'unknown_recognised': (2 / 3, 3),
        'unknown_balance': (0.5, 2),
        'uncalibrated_top1': (1.0, 1),
        'uncalibrated_alarm': (1 / 3, 3),
        'systems_top1': (1.0, 1),
        'systems_alarm': (1.0, 1),
        'noise_3_top1': (None, 0),
        'noise_10_top1': (1.0, 1),
        'noisy_alarm': (None, 0),
        'heldout_gap_cut': (0.7, 3),
        'parameter_error': (0.11, 1),
        'interval_coverage': (2 / 3, 3),
        'where_gas': (1.0, 2),  # valve_lag, supply_droop removed
        'where_force': (3 / 6, 6),
        'where_sensor': (1.0, 1),
        'where_empty': (1 / 11, 11),
        'where_missing': (1 / 13, 13),
        'null_listings': (0.5, 4),
        'times_f1': (2 / 3, 3),
        'times_f1_pooled': (round(8 / 13, DIGITS), 3),
        'seconds_named': (60.0, 10),
        'seconds_unknown': (60.0, 2),
    }


def test_figures_of_nothing_are_none_and_not_reached() -> None:
    for name, figure in scores.figures([]).items():
        assert (figure['value'], figure['trials']) == (None, 0)
        assert not scores.reached(name, figure['value'])


def test_every_figure_is_explained_and_has_a_goal() -> None:
    assert set(scores.figures([])) == set(scores.WANTED)


def test_page_and_figures_are_those_of_the_answers_kept(tmp_path: Path) -> None:
    docs = ROOT / 'docs'
    told = json.loads((docs / 'blind.json').read_text())
    page.write_kept(docs / FOLDER, tmp_path, told['revision'], told['seed'])
    for name in ('blind.md', 'blind.json'):
        assert (tmp_path / name).read_text() == (docs / name).read_text()


QUOTED = {
    'an effect by another formula': (foreign_scores, 'blind_foreign', 'foreign_mechanism'),
    'an effect by a formula of a second list': (
        foreign_scores,
        'blind_foreign',
        'second_mechanism',
    ),
    'two effects by other formulas': (foreign_scores, 'blind_foreign', 'foreign_pairs_both'),
    'a mechanism not in the library': (foreign_scores, 'blind_foreign', 'foreign_unknown'),
    'a strong cause among weak nuisances': (foreign_scores, 'blind_foreign', 'nuisance_cause'),
    'weak nuisances alone': (foreign_scores, 'blind_foreign', 'nuisance_alarm'),
    "an effect by the library's formula": (scores, 'blind', 'single_top1'),
    'an effect removed from the library': (scores, 'blind', 'unknown_recognised'),
    'an effect, sensors not calibrated': (scores, 'blind', 'uncalibrated_top1'),
}
"""Rows of the README -> where the figure is, and what is wanted."""


@pytest.mark.parametrize('hidden', QUOTED)
def test_readme_quotes_the_figures_of_the_pages(hidden: str) -> None:
    module, name, key = QUOTED[hidden]
    figure = json.loads((ROOT / 'docs' / f'{name}.json').read_text())[key]
    rows = (ROOT / 'README.md').read_text().splitlines()
    (row,) = (each for each in rows if each.startswith(f'| {hidden} | '))
    share, wanted = 100 * figure['value'], module.WANTED[key]
    bound = f'{100 * wanted.bound:.0f} %'
    if wanted.sense == 'at most':
        bound = f'at most {bound}'
    assert row.endswith(f' | {share:.0f} % | {figure["trials"]} | {bound} |')


def test_readme_counts_the_targets_that_are_missed() -> None:
    figures = json.loads((ROOT / 'docs' / 'blind.json').read_text())
    drawn = [n for n in scores.WANTED if figures[n]['trials']]
    missed = [n for n in drawn if not scores.reached(n, figures[n]['value'])]
    readme = (ROOT / 'README.md').read_text()
    assert f'{len(missed)} of {len(drawn)} targets are missed' in readme


def test_page_lists_every_miss_with_its_kind(tmp_path: Path) -> None:
    page.write(ANSWERS, tmp_path, 'abc', others={'before': ANSWERS, 'old': ANSWERS[:6]})
    text = (tmp_path / 'blind.md').read_text()
    causes = text.split('## Misses')[1]
    assert causes.count('\n| `') == 2 + 1 + 1 + 1 + 2 + 1 + 1
    assert 'reported as indistinguishable from the right one' in causes
    assert 'one found, not all' in causes
    assert 'put on another balance: gas_2' in causes
    assert 'fits noise' in causes
    assert 'single/load_spring' not in causes
    # Wilson: (p + z^2/2n -+ z sqrt(p(1-p)/n + z^2/4n^2)) / (1 + z^2/n) with 1 of 3, z = 1.96
    assert '| 33.3 % | 6 % to 79 % | at least 95 % | no | 3 |' in text
    assert '| 60.0 | - | at most 60.0 | yes | 2 |' in text
    # mean and RMS of 100 and 300 residuals together
    assert '| gas_1 | dwell | 2 | 400 | 0.05 (-0.10 to 0.50) | 1.80 (1.00 to 2.00) |' in text
    assert '| figure | before | old |' in text
    assert 'shares the functional forms' in ' '.join(text.split('\n')[:5])
    written = json.loads((tmp_path / 'blind.json').read_text())
    assert written['single_top1']['value'] == 1 / 3
    assert (tmp_path / page.PICTURE).stat().st_size < 200_000


def test_revisions_are_compared_on_what_both_answered() -> None:
    text = page_tables.comparison({'new': ANSWERS, 'old': ANSWERS[:1]})
    assert text.startswith('1 trials')
    row = next(line for line in text.splitlines() if '`single_top1`' in line)
    assert row == '| `single_top1` | 100.0 % (21 % to 100 %; 1) | 100.0 % (21 % to 100 %; 1) |'


def test_confusion_puts_each_answer_in_its_cell() -> None:
    columns, counts = confusion(ANSWERS)
    rows = dict(zip([*EFFECTS, 'nothing'], counts, strict=True))
    assert rows['valve_lag'][columns.index('line_lag')] == 1
    assert rows['inclination'][columns.index('a parameter')] == 1
    assert rows['nothing'][columns.index('consistent')] == 2
    assert counts.sum() == 6


@pytest.mark.parametrize(('interval', 'covered'), [([0.05, 0.07], True), ([0.065, 0.07], False)])
def test_truth_is_joined_to_an_answer_with_the_error_of_its_parameters(
    interval: list[float], covered: bool
) -> None:
    trial = next(t for t in matrix() if t.key == 'single/inclination/cylinder_1/medium/1')
    angle = {'value': 0.066, 'interval': interval}
    said = {
        'verdict': 'effect',
        'candidates': [{'names': ['inclination'], 'chosen': True, 'probability': 0.6},
                       {'names': ['load_spring', 'stribeck'], 'chosen': False}],
        'effects': [{'name': 'inclination', 'parameters': {'angle': angle}}],
        'gap': {'before': 5.0, 'after': 0.5, 'cut': 0.9},
        'where': [{'balance': 'force'}],
        'intervals': [{'balance': 'force', 'recording': 'fit_1', 'from': 0.0, 'to': 14.0},
                      {'balance': 'gas_1', 'recording': 'fit_1', 'from': 0.0, 'to': 14.0},
                      {'balance': 'force', 'recording': 'verify_1', 'from': 0.0, 'to': 14.0}],
    }  # fmt: skip
    line = joined(trial, said)
    assert scores.named_first(line)
    assert line['ranking'] == ['inclination', 'load_spring+stribeck']
    assert abs(line['errors']['inclination.angle'] - 0.1) < 1e-9
    assert line['covered'] == {'inclination.angle': covered}
    assert line['probability'] == 0.6
    assert line['visibility'] > scores.VISIBLE
    assert line['times']['told'] == 14.0
    assert 10.0 < line['times']['true'] < 40.0  # the piston slides so long in the four bags
    assert 2.0 < line['times']['shared'] < line['times']['told']
    assert json.loads(json.dumps(line)) == line


def test_answer_of_a_system_is_joined_with_its_own_truth() -> None:
    trial = next(t for t in drawn(3) if t.part == 'leaking_chamber' and 'chamber_leak' in t.names)
    area = trial.secret.effects['chamber_leak']['area_1']
    row = {'value': 1.1 * area, 'interval': [0.9 * area, 1.3 * area]}
    effect = {'name': 'chamber_leak', 'parameters': {'area_1': row}}
    line = joined(trial, {'verdict': 'effect', 'effects': [effect]})
    assert line['errors'] == pytest.approx({'chamber_leak.area_1': 0.1})
    assert line['covered'] == {'chamber_leak.area_1': True}
    assert line['times']['true'] > 100.0
