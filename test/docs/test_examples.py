"""The examples run as they are, and the effect of the page "add an effect" is a whole one."""

import importlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.model import assembly
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.effect import Effect
from pneu_rig_ros.model.plant import Plant, Trajectory
from pneu_rig_ros.rig import configuration_from_yaml, load_configuration

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / 'examples'
NEEDS_ROS = {'own_controller.py'}  # test/ros/test_own_controller.py
INTERVAL = 1.16e-3


def run(name: str, *arguments: object) -> list[str]:
    """Run an example in a process of its own; return its lines."""
    process = subprocess.run(
        [sys.executable, str(EXAMPLES / name), *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert process.returncode == 0, process.stderr
    assert process.stderr == ''
    return process.stdout.splitlines()


def test_cycles_are_counted() -> None:
    head, *cycles = run('count_cycles.py')
    assert head.startswith(f'{len(cycles)} cycles on ')
    assert len(cycles) > 3


def test_leaking_chamber_is_slower() -> None:
    tight, leaking = (float(line.split()[1]) for line in run('leaking_chamber.py'))
    assert 1.0 < leaking < 0.5 * tight


def test_friction_of_a_bag(bag: Path) -> None:
    head, peaks = run('friction_of_a_bag.py', bag)
    assert head.startswith('cylinder_2: mean ')
    assert 15.0 < float(peaks.split()[5]) < 25.0


def test_every_example_is_tested_and_in_the_docs() -> None:
    pages = (ROOT / 'docs' / 'examples.md').read_text()
    source = Path(__file__).read_text()
    programs = {path.name for path in EXAMPLES.glob('*.py')}
    assert programs > NEEDS_ROS
    for name in programs:
        assert name in pages
        assert name in source


@pytest.fixture
def plain() -> Trajectory:
    """Return a stroke of cylinder 3 without the effect."""
    return stroke(Plant(load_configuration('cylinder_3').model))


@pytest.fixture
def drag(plain: Trajectory, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Effect]:
    """Give the library the folder of the example, as if its file had been put there."""
    monkeypatch.setattr(library, '__path__', [*library.__path__, str(EXAMPLES / 'effects')])
    # The name of a kept plant says nothing of files outside of the package.
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))
    library.names.cache_clear()
    yield library.load('air_drag')
    library.names.cache_clear()
    assembly._assemble.cache_clear()
    sys.modules.pop(f'{library.__name__}.air_drag')
    delattr(importlib.import_module(library.__name__), 'air_drag')


def stroke(plant: Plant) -> Trajectory:
    return plant.run(np.tile((3.0, 2.0), (round(2.0 / INTERVAL), 1)), INTERVAL)


def test_effect_of_the_page_works(plain: Trajectory, drag: Effect) -> None:
    text = (ROOT / 'config' / 'cylinder_3.yaml').read_text()
    configuration = configuration_from_yaml(
        f'{text}\neffects: {{air_drag: {{coefficient: 5000 N*s^2/m^2}}}}\n', 'my_rig.yaml'
    )
    model, strength = configuration.model, configuration.effects['air_drag']
    assert strength == drag.parameters(5000.0)
    nulled = stroke(Plant(model, {'air_drag': drag.null}))
    for name, column in plain._asdict().items():
        assert np.array_equal(column, getattr(nulled, name)), name
    dragged = stroke(Plant(model, {'air_drag': strength}))
    assert dragged.velocity.max() < 0.9 * plain.velocity.max()
    assert dragged.position.max() > 0.01


def test_page_shows_the_file_that_is_tested() -> None:
    page = (ROOT / 'docs' / 'add_effect.md').read_text()
    assert '```{literalinclude} ../examples/effects/air_drag.py' in page
