"""`pneu-rig effects` lists the whole library."""

import json

from pneu_rig_ros.model import effects

from .conftest import Terminal


def test_every_effect_and_parameter_is_listed(terminal: Terminal) -> None:
    outcome = terminal.run('effects')
    assert outcome.code == 0
    for name in effects.names():
        effect = effects.load(name)
        assert f'\n{name} ' in outcome.out
        for parameter in effect.parameters._fields:
            assert f'{parameter}: ' in outcome.out
        assert effect.source.split()[0] in outcome.out


def test_json_says_the_same_as_the_library(terminal: Terminal) -> None:
    data = json.loads(terminal.run('effects', '--json').out)
    assert tuple(data) == effects.names()
    droop = data['supply_droop']
    assert droop['balance'] == 'supply'
    assert droop['parameters']['resistance']['unit'] == 'Pa*s/kg'
    for name, entry in data.items():
        null = {key: parameter['null'] for key, parameter in entry['parameters'].items()}
        assert null == effects.load(name).null._asdict()
        assert entry['regimes'] == list(effects.load(name).regimes)
        assert entry['probes'] == [probe._asdict() for probe in effects.load(name).probes]
    assert data['stribeck']['laws'] == ['coulomb_viscous']
