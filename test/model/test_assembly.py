"""The compiled plant on disk: found again, never stale, and a clear word when it has no place."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier

import numba
import numpy as np
import pytest

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model import assembly
from pneu_rig_ros.model.compiled import compiled


def test_module_is_written_once_and_named_after_sources_and_effects(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))
    first = assembly._module(())
    again = assembly._module(())
    leaky = assembly._module(('chamber_leak',))
    assert first.__file__ == again.__file__ != leaky.__file__
    assert len(list((tmp_path / 'pneu_rig_ros').glob('plant_*.py'))) == 2
    assert "('chamber_leak',)" in Path(str(leaky.__file__)).read_text()


def test_threads_that_start_together_keep_one_module(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))
    threads, barrier = 8, Barrier(8)

    def keep(number: int) -> str:
        barrier.wait()
        return str(assembly.kept_module(f'module_{number}', f'NUMBER = {number}\n').__file__)

    with ThreadPoolExecutor(threads) as pool:
        for number in range(50):
            assert len(set(pool.map(keep, [number] * threads))) == 1
    kept = [path for path in (tmp_path / 'pneu_rig_ros').iterdir() if path.is_file()]
    assert len(kept) == 50  # and no partial ones
    with ThreadPoolExecutor(threads) as pool:
        plants = list(pool.map(assembly.assemble, [('load_spring', 'chamber_leak')] * threads))
    assert all(plant is plants[0] for plant in plants)


def test_a_cache_that_cannot_be_written_is_told_with_the_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / 'file').write_text('')
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'file'))
    with pytest.raises(RigError, match='set XDG_CACHE_HOME'):
        assembly._module(())


def test_blocks_do_not_count_references_to_arrays() -> None:
    """Counting took six sevenths of the time of a plant; no other test would see it come back."""

    @compiled
    def total(rows: tuple[Floats, ...], first: int) -> float:
        value = 0.0
        for i in range(len(rows)):
            value += rows[i][first:][0]
        return value

    @numba.njit(error_model='numpy', nogil=True, _nrt=False)  # type: ignore[untyped-decorator]
    def whole(rows: tuple[Floats, ...], first: int) -> float:
        return total(rows, first)

    assert whole((np.ones(3), np.ones(3)), 1) == 2.0
    assert 'NRT_incref' not in ''.join(whole.inspect_llvm().values())


ONE_STROKE = """
import sys

import numpy as np

from pneu_rig_ros.model import effects
from pneu_rig_ros.model.plant import Plant
from pneu_rig_ros.rig import load_configuration

for name in sys.argv[1:]:
    plant = Plant(load_configuration('cylinder_1').model, {name: effects.load(name).probes[0]})
    print(name, *plant.run(np.full((500, 2), (2.9, 2.1)), 0.00116).position[-1:].tolist())
"""


def strokes(*effects: str) -> subprocess.Popen[str]:
    """Start a process of its own in which plants with one effect each make a stroke."""
    command = [sys.executable, '-c', ONE_STROKE, *effects]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


@pytest.mark.long  # it compiles two plants; in short: each effect has a module of its own, above
def test_plants_compiled_by_different_processes_are_not_mistaken_for_each_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To Numba the functions of all plants have the same signatures."""
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))
    apart = [strokes('inclination'), strokes('position_scale')]
    alone = [process.communicate()[0] for process in apart]
    together, _ = strokes('inclination', 'position_scale').communicate()
    assert together == ''.join(alone)
    assert len(set(together.split())) == 4
