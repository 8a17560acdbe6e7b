"""Small bags to read, cut and repair."""

from collections.abc import Callable
from pathlib import Path

import pytest

from pneu_rig_ros.records import writer
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate


@pytest.fixture(scope='session')
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One simulated second of cylinder 2 in some 30 chunks; not to be changed."""
    configuration = load_configuration('cylinder_2', seed=7)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(writer, 'CHUNK_SIZE', 20_000)
        return simulate(configuration, 0.34, 1.0, tmp_path_factory.mktemp('bags') / 'second')


@pytest.fixture
def cut(bag: Path, tmp_path: Path) -> Callable[[int], Path]:
    """Return a copy of the bag as a killed recorder leaves it: the first bytes, no metadata."""

    def copy(size: int) -> Path:
        directory = tmp_path / f'cut_{size}'
        directory.mkdir()
        content = (bag / f'{bag.name}.mcap').read_bytes()
        (directory / f'{directory.name}.mcap').write_bytes(content[:size])
        return directory

    return copy
