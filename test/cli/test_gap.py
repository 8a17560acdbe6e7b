"""The demonstration of the gap: what is hidden comes out, and nothing is left of a broken run."""

import contextlib
import json
import os
import re
import signal
from pathlib import Path

import numpy as np
import pytest
from terminal import Terminal

from pneu_rig_ros.analysis.metrics import SignalGap
from pneu_rig_ros.cli.diagnosis import _whole, gap_to_dict
from pneu_rig_ros.model.effects import causes
from pneu_rig_ros.model.quantity import LARGEST_INTEGER
from pneu_rig_ros.records import read_recording
from pneu_rig_ros.rig import configuration_from_yaml, load_configuration
from pneu_rig_ros.scenarios.experiments import (
    FIT,
    NAMES,
    VERIFY,
    Experiment,
    levels,
    profile,
    set_up,
)
from pneu_rig_ros.scenarios.gap import DRAWN, Outcome, draw, noise_seed
from pneu_rig_ros.scenarios.hidden import EFFECTS, LAWS

from .test_commands import until
from .test_demo import children, gone, recording


@pytest.mark.live
@pytest.mark.long
def test_hidden_effect_comes_out_and_the_gap_closes(terminal: Terminal) -> None:
    words = ('gap', '--seed', 7, '--effect', 'inclination', '--out', 'gap')
    with terminal.start(*words) as process:
        out, err = process.communicate()
    assert process.returncode == 0, err
    folder = terminal.directory / 'gap'
    answer = json.loads((folder / 'answer' / 'diagnosis.json').read_text())
    assert [one['name'] for one in answer['effects']] == ['inclination']
    angle = answer['effects'][0]['parameters']['angle']['value']
    assert angle == pytest.approx(0.06, rel=0.02)
    assert answer['gap']['cut'] > 0.8
    closed = dict(re.findall(r'^(position|velocity|pressure 1) .* (\d+)%$', out, re.MULTILINE))
    assert len(closed) == 3
    assert min(map(int, closed.values())) > 80
    (friction,) = re.findall(r'^friction +\S+ +(\S+) +(\S+) +N +near noise$', out, re.MULTILINE)
    assert float(friction[0]) < 1.05 * float(friction[1])
    assert out.index('gap closed') < out.index('hidden             inclination: angle 0.06 rad')
    assert (folder / 'gap.png').stat().st_size > 20_000
    assert 'no gain errors' in out
    recorded = dict(zip(NAMES, (*FIT, *VERIFY), strict=True))
    assert {path.name for path in (folder / 'measured').iterdir()} == set(NAMES)
    _check_runs_are_the_experiments(folder, recorded)


def _check_runs_are_the_experiments(folder: Path, experiments: dict[str, Experiment]) -> None:
    model = load_configuration(folder / 'model.yaml')
    assert model.effects == {}
    for name, experiment in experiments.items():
        bag = folder / 'measured' / name
        record = read_recording(bag)
        # the bag tells what is hidden, as that of any plant does: the diagnosis looks away
        assert record.configuration is not None
        assert 'inclination' in record.configuration.effects
        expected = set_up(experiment, 'cylinder_1', model.model.cylinder.stroke)
        del expected['initial_position']
        known = record.conditions
        assert {key: known[key] for key in expected} == pytest.approx(expected)
        length = sum(duration for duration, _ in levels(experiment, 'cylinder_1'))
        assert record.duration == pytest.approx(length, abs=0.05)


@pytest.mark.parametrize('experiment', [*FIT, *VERIFY], ids=NAMES)
def test_profile_is_the_timeline(experiment: Experiment) -> None:
    shape = profile(experiment, 'cylinder_1')
    held = [float(level.split()[0]) for level in shape['levels']]
    pieces = levels(experiment, 'cylinder_1')
    command = np.concatenate([np.full(round(10 * duration), u) for duration, u in pieces])
    assert held == pytest.approx(command)


def test_outcome_as_plain_data_tells_all(tmp_path: Path) -> None:
    gap = SignalGap('m', 2e-3, 5e-3, 1e-4, 1e-4)
    outcome = Outcome({'verdict': 'effect'}, {'position': gap}, {'position': gap})
    data = json.loads(json.dumps(gap_to_dict(outcome, draw(7, 'inclination'), 7, tmp_path)))
    assert data == {
        'seed': 7,
        'hidden': 'inclination',
        'directory': str(tmp_path),
        'gap': {'position': {'before': 2e-3, 'after': 2e-3, 'noise': 1e-4, 'unit': 'm'}},
        'diagnosis': {'verdict': 'effect'},
    }


@pytest.mark.live
def test_interrupted_demonstration_leaves_no_node_and_no_file(terminal: Terminal) -> None:
    # of a friction law: its plant has no effects and is compiled already
    with terminal.start('gap', '--seed', 7, '--effect', 'stribeck', '--out', 'gap') as process:
        bag = terminal.directory / '.gap.unfinished' / 'measured' / NAMES[0]
        until(lambda: recording(bag), process)
        numbers = [number for _, number in children(process)]
        os.kill(process.pid, signal.SIGINT)
        _, err = process.communicate()
    assert process.returncode == 130
    assert 'Traceback' not in err
    assert numbers
    assert gone(numbers)
    assert list(terminal.directory.iterdir()) == []


def test_broken_run_leaves_no_directory(tmp_path: Path) -> None:
    broken = contextlib.suppress(KeyboardInterrupt)
    with broken, _whole(tmp_path / 'a' / 'b' / 'gap') as folder:
        (folder / 'gap.png').touch()
        raise KeyboardInterrupt
    assert list(tmp_path.iterdir()) == []
    with _whole(tmp_path / 'a' / 'gap') as folder:
        (folder / 'gap.png').touch()
    assert [path.name for path in tmp_path.glob('a/*')] == ['gap']
    assert (tmp_path / 'a' / 'gap' / 'gap.png').exists()


@pytest.mark.parametrize('name', EFFECTS)
def test_every_effect_can_be_hidden(name: str) -> None:
    secret = draw(0, name)
    assert list(secret.truth.effects) == ([] if name in LAWS else [name])
    assert configuration_from_yaml(secret.truth.to_yaml(), 'truth') == secret.truth
    assert secret.model.effects == {}
    assert secret.truth != secret.model
    assert all(key in secret.text for key in secret.parameters)


def test_help_tells_from_how_many_effects_is_drawn(terminal: Terminal) -> None:
    text = ' '.join(terminal.output('gap', '--help').split())
    assert f'one of {len(DRAWN)} of the {len(causes())} effects' in text
    assert set(DRAWN) < set(causes())


def test_seed_draws_the_effect() -> None:
    drawn = [draw(seed).effect for seed in range(40)]
    assert drawn == [draw(seed).effect for seed in range(40)]
    assert len(set(drawn)) > len(DRAWN) / 2


def test_noise_of_every_run_has_a_seed_that_a_rig_takes() -> None:
    assert [noise_seed(7, run) for run in (0, 2, -1)] == [8000, 8002, 7999]
    load_configuration('cylinder_1', seed=noise_seed(LARGEST_INTEGER, 3))


@pytest.mark.parametrize('name', ['described_force', 'no_such_effect'])
def test_what_cannot_be_hidden_is_refused(terminal: Terminal, name: str) -> None:
    assert name in terminal.refusal('gap', '--effect', name)
    assert list(terminal.directory.iterdir()) == []
