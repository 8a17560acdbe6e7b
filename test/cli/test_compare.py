"""`pneu-rig compare`."""

import json
from pathlib import Path

from terminal import Terminal


def test_model_that_made_the_bag_is_near_it(terminal: Terminal, bag: Path) -> None:
    data = json.loads(terminal.output('compare', bag, '--model', 'cylinder_2', '--json'))
    assert set(data['signals']) == {'position', 'velocity', 'pressure_1', 'pressure_2', 'friction'}
    assert data['signals']['pressure_2']['unit'] == 'Pa'
    assert data['signals']['pressure_2']['multiple'] < 2.0
    assert data['conditions']['load_mass'] == {'value': 0.2, 'unit': 'kg', 'from': 'bag'}
    events = data['events']
    assert events['measured']['cycle_count'] == events['model']['cycle_count'] > 0
    assert events['measured']['stroke_time'] is None


def test_tables_and_page(terminal: Terminal, bag: Path) -> None:
    command = ('compare', bag, '--model', 'cylinder_2', '--out', 'page.html')
    tables = terminal.output(*command)
    for text in ('RMSE / noise', 'pressure 2', 'median dwell', 'supply pressure 400000 Pa'):
        assert text in tables
    page = (terminal.directory / 'page.html').read_text()
    assert page.startswith('<!DOCTYPE html>')
    note = 'diagnose fits these gains'
    assert note in tables
    assert note in page
    assert note not in terminal.output('compare', bag, '--model', bag)
    assert 'page.html exists' in terminal.refusal(*command)
    assert terminal.run('compare', bag, '--model', bag, '--quiet') == (0, '', '')


def test_what_is_wrong_is_said(terminal: Terminal, bag: Path) -> None:
    for arguments, message in (
        ((bag, '--model', 'cylinder_9'), "did you mean 'cylinder_"),
        (('none', '--model', 'cylinder_2'), 'does not exist'),
        ((bag, '--model', 'cylinder_2', '--shift', '1'), '--shift is for two bags'),
        ((bag, '--model', bag, '--shift', '90'), 'do not overlap'),
        ((bag,), '--model'),
    ):
        assert message in terminal.refusal('compare', *arguments)
