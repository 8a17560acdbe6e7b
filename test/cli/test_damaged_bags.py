"""Every command says the same of a bag that it cannot read, and names `repair` if that helps."""

import random
from pathlib import Path

import pytest
from terminal import Terminal

from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate

MAPPING = 'topics: {position: {topic: /joint_states}, pressure_1: /chamber_1/pressure}\n'
COMMANDS = ('info', 'view', 'friction', 'export', 'compare', 'replay', 'import')


def run(terminal: Terminal, name: str, bag: Path) -> str:
    """Run a command on a bag; return the only line that it says."""
    (bag.parent / 'map.yaml').write_text(MAPPING)
    options = {
        'export': ['--csv'],
        'compare': ['--model', 'cylinder_1'],
        'import': ['--map', bag.parent / 'map.yaml', '--out', bag.parent / 'imported'],
    }
    return terminal.refusal(name, bag, *options.get(name, []))


@pytest.fixture(scope='module')
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Return the file of a bag with several chunks."""
    bag = tmp_path_factory.mktemp('whole') / 'bag'
    simulate(load_configuration('cylinder_1'), 0.3, 4.0, bag)
    return (bag / 'bag.mcap').read_bytes()


def write(folder: Path, data: bytes) -> Path:
    bag = folder / 'bag'
    bag.mkdir()
    (bag / 'bag.mcap').write_bytes(data)
    return bag


@pytest.mark.parametrize('name', COMMANDS)
def test_repair_is_named_for_a_bag_that_is_cut(
    name: str, terminal: Terminal, whole: bytes, tmp_path: Path
) -> None:
    bag = write(tmp_path, whole[: len(whole) * 3 // 4])
    line = run(terminal, name, bag)
    assert f'{bag} is cut off or damaged (' in line
    assert line.endswith(f'; run: pneu-rig repair {bag}')
    terminal.output('repair', bag)
    terminal.output('info', bag)


@pytest.mark.parametrize('name', [*COMMANDS, 'repair'])
@pytest.mark.parametrize('content', ['random', 'empty', 'text', 'first bytes'])
def test_repair_is_not_named_where_nothing_can_be_recovered(
    name: str, content: str, terminal: Terminal, whole: bytes, tmp_path: Path
) -> None:
    data = {
        'random': random.Random(3).randbytes(50_000),
        'empty': b'',
        'text': b'time, position\n' * 1000,
        'first bytes': whole[:60],
    }[content]
    bag = write(tmp_path, data)
    reason = 'is not a bag, or was cut off before its first message: nothing to recover'
    assert run(terminal, name, bag) == f'{bag} {reason}'
