"""The judges, on answers written by hand."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from . import page, scores
from .answers import KEPT, joined, kept
from .confusion import confusion
from .hidden import EFFECTS
from .trials import matrix

ROOT = Path(__file__).resolve().parents[2]


def answer(part: str, names: list[str], verdict: str, **more: Any) -> dict[str, Any]:
    """Return an answer as it is kept."""
    base = {
        'key': f'{part}/{"+".join(names)}/{verdict}', 'part': part, 'cylinder': 'cylinder_1',
        'noise': 1.0, 'strength': 'medium', 'names': names, 'visibility': 50.0,
        'verdict': verdict, 'error': '', 'ranking': [], 'effects': [], 'parameters': [],
        'alike': [], 'balance': '', 'where': [], 'before': 9.0, 'after': 1.0, 'cut': None,
        'errors': {}, 'baselines': {}, 'seconds': 60.0, 'revision': 'x',
    }  # fmt: skip
    return {**base, **more}


ANSWERS = [
    answer('single', ['stribeck'], 'effect', ranking=['stribeck'], effects=['stribeck'], cut=0.9,
           errors={'stribeck.excess': 0.02, 'stribeck.stribeck_velocity': 0.2},
           covered={'stribeck.excess': True, 'stribeck.stribeck_velocity': False},
           baselines={'refit': 0.3, 'sparse': -0.2, 'black box': 0.1}),
    answer('single', ['valve_lag'], 'effect', ranking=['line_lag', 'valve_lag'],
           effects=['line_lag'], alike=[['line_lag', 'valve_lag']], cut=0.7),
    answer('single', ['inclination'], 'parameter', parameters=['friction.coulomb_force'], cut=0.1),
    answer('single', ['load_spring'], 'consistent', visibility=1.0),
    answer('single', ['load_spring'], 'effect', effects=['load_spring'], noise=10.0),
    answer('none', [], 'consistent'),
    answer('none', [], 'consistent'),
    answer('none', [], 'effect', ranking=['inclination'], effects=['inclination']),
    answer('parameter', ['friction.coulomb_force'], 'parameter',
           ranking=['friction.coulomb_force'], parameters=['friction.coulomb_force']),
    answer('parameter', ['friction.coulomb_force'], 'effect', effects=['inclination']),
    answer('pair', ['supply_droop', 'inclination'], 'effect',
           ranking=['inclination'], effects=['inclination', 'supply_droop']),
    answer('pair', ['supply_droop', 'inclination'], 'effect',
           ranking=['inclination'], effects=['inclination']),
    answer('removed', ['supply_droop'], 'unknown', balance='gas mass 1'),
    answer('removed', ['inclination'], 'unknown', balance='gas mass 2'),
    answer('removed', ['stribeck'], 'effect', ranking=['inclination'], effects=['inclination']),
    answer('unseen', ['stribeck'], 'effect', strength='0.71', effects=['stribeck']),
    answer('unseen', ['load_spring'], 'unknown', strength='1.90'),
    answer('unseen', ['friction.coulomb_force'], 'parameter', strength='',
           parameters=['friction.coulomb_force'], covered={'friction.coulomb_force': True}),
    answer('uncalibrated', ['stribeck'], 'effect', effects=['stribeck']),
    answer('uncalibrated', [], 'consistent'),
    answer('uncalibrated', [], 'parameter', parameters=['friction.coulomb_force']),
]  # fmt: skip


def test_figures_count_what_is_right_and_visible() -> None:
    found = {name: tuple(f.values()) for name, f in scores.figures(ANSWERS).items()}
    assert found == {
        'single_top1': (1 / 3, 3),
        'false_alarm': (1 / 3, 3),
        'parameter_top1': (0.5, 2),
        'pairs_both': (0.5, 2),
        'unknown_recognised': (2 / 3, 3),
        'unknown_balance': (0.5, 2),
        'unseen_effect': (0.5, 2),
        'unseen_parameter': (1.0, 1),
        'uncalibrated_top1': (1.0, 1),
        'uncalibrated_alarm': (0.5, 2),
        'heldout_gap_cut': (0.7, 3),
        'parameter_error': (0.11, 1),
        'interval_coverage': (2 / 3, 3),
    }


def test_figures_of_nothing_are_none_and_not_reached() -> None:
    for name, figure in scores.figures([]).items():
        assert figure == {'value': None, 'trials': 0}
        assert not scores.reached(name, figure['value'])


def test_readme_tells_the_figures_of_the_page() -> None:
    figures = json.loads((ROOT / 'docs' / 'blind.json').read_text())
    section = (ROOT / 'README.md').read_text().split('`make blind`')[1].split('##')[0]
    rows = [line for line in section.splitlines() if line.startswith('| ')][2:]
    names = ('single_top1', 'false_alarm', 'parameter_top1', 'pairs_both', 'unknown_recognised',
             'unknown_balance')  # fmt: skip
    for row, name in zip(rows, names, strict=True):
        figure = figures[name]
        low_high = page.interval(name, figure).replace(' % to', ' to')
        assert f': {page.percent(figure["value"])} | {figure["trials"]} | {low_high} |' in row
    assert f'cut by {page.percent(figures["heldout_gap_cut"]["value"])}' in section
    assert f'{page.percent(figures["parameter_error"]["value"], 1)} off' in section
    for name, text in (
        ('uncalibrated_top1', 'stands first in {} of {} trials'),
        ('uncalibrated_alarm', 'missing in {} of {} with nothing hidden'),
        ('interval_coverage', 'hold the truth in {} of {} '),
    ):
        value, count = figures[name]['value'], figures[name]['trials']
        assert text.format(round(value * count), count) in section.replace('\n', ' ')
    (refit,) = re.findall(
        rf'{page.BASELINES["refit"]} \| (\d+ %)', (ROOT / 'docs' / 'blind.md').read_text()
    )
    assert f'instead cuts the gap by {refit}.' in section


def test_page_and_figures_are_those_of_the_answers_kept(tmp_path: Path) -> None:
    docs = ROOT / 'docs'
    page.write(kept(docs / KEPT), tmp_path)
    for name in ('blind.md', 'blind.json'):
        assert (tmp_path / name).read_text() == (docs / name).read_text()


def test_page_lists_every_miss_with_its_kind(tmp_path: Path) -> None:
    page.write(ANSWERS, tmp_path)
    text = (tmp_path / 'blind.md').read_text()
    causes = text.split('## Misses')[1]
    assert causes.count('\n| `') == 2 + 1 + 1 + 1 + 2 + 1 + 1
    assert 'said to be inseparable from the right one' in causes
    assert 'one found, not all' in causes
    assert 'put on another balance: gas mass 2' in causes
    assert 'fits noise' in causes
    assert 'single/load_spring' not in causes
    # Wilson: (p + z^2/2n -+ z sqrt(p(1-p)/n + z^2/4n^2)) / (1 + z^2/n) with 1 of 3, z = 1.96
    assert '| 33.3 % | 6 % to 79 % | at least 95% | no | 3 |' in text
    assert '| this workflow | 90 % | 90 % to 90 % | 1 | 1 of 1 |' in text
    assert '(pysindy) | -20 % | -20 % to -20 % | 1 |' in text
    written = json.loads((tmp_path / 'blind.json').read_text())
    assert written['single_top1'] == {'value': 1 / 3, 'trials': 3}
    assert (tmp_path / page.PICTURE).stat().st_size < 200_000


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
        'candidates': [{'names': ['inclination']}, {'names': ['load_spring', 'stribeck']}],
        'effects': [{'name': 'inclination', 'parameters': {'angle': angle}}],
        'gap': {'before': 5.0, 'after': 0.5, 'cut': 0.9},
        'where': [{'balance': 'force'}],
    }
    line = joined(trial, said)
    assert scores.named_first(line)
    assert line['ranking'] == ['inclination', 'load_spring+stribeck']
    assert abs(line['errors']['inclination.angle'] - 0.1) < 1e-9
    assert line['covered'] == {'inclination.angle': covered}
    assert line['visibility'] > scores.VISIBLE
    assert json.loads(json.dumps(line)) == line
