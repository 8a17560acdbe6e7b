"""`pneu-rig effects` lists the whole library."""

import json
from pathlib import Path

from terminal import Terminal

from pneu_rig_ros.model import effects


def test_every_effect_and_parameter_is_listed(terminal: Terminal) -> None:
    text = terminal.output('effects')
    for name in effects.names():
        effect = effects.load(name)
        assert f'\n{name} ' in text
        for parameter in effect.parameters._fields:
            assert f'{parameter}: ' in text
        assert effect.source.split()[0] in text


def test_json_says_the_same_as_the_library(terminal: Terminal) -> None:
    data = json.loads(terminal.output('effects', '--json'))
    assert tuple(data) == effects.names()
    droop = data['supply_droop']
    assert droop['balance'] == 'supply'
    assert droop['parameters']['resistance']['unit'] == 'Pa*s/kg'
    for name, entry in data.items():
        null = {key: parameter['null'] for key, parameter in entry['parameters'].items()}
        assert null == effects.load(name).null._asdict()
        assert entry['regimes'] == [regime.label for regime in effects.load(name).regimes]
        assert entry['probes'] == [probe._asdict() for probe in effects.load(name).probes]
    assert data['stribeck']['laws'] == ['coulomb_viscous']
    assert data['load_spring']['drivers'] == ['position']


def test_descriptions_stand_apart_and_are_no_causes(terminal: Terminal) -> None:
    above, below = terminal.output('effects').split('\nEmpirical terms, not physical causes')
    data = json.loads(terminal.output('effects', '--json'))
    for name in effects.names():
        is_cause = not name.startswith('empirical_')
        assert (f'\n{name} ' in above, f'\n{name} ' in below) == (is_cause, not is_cause)
        assert data[name]['describes'] is not is_cause
        assert (name in effects.causes()) is is_cause
    readme = (Path(__file__).parents[2] / 'README.md').read_text()
    assert f'{len(effects.causes())} optional physical effects' in readme
    assert f'the {len(effects.names()) - len(effects.causes())} empirical terms' in readme


def test_only_causes_are_offered_to_be_left_out_of_a_diagnosis(terminal: Terminal) -> None:
    command = ('diagnose', 'a', '--model', 'm', '--out', 'o', '--without', 'stribec')
    line = terminal.refusal(*command)
    assert "--without: unknown name 'stribec', did you mean 'stribeck'" in line
    assert 'empirical_' not in line
