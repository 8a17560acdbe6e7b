"""
The plant put together from equations and effects, compiled once and kept on disk.

Numba finds a cached function by the file that holds it. A small module is therefore written for
each set of effects into the user's cache folder, under a name that changes with every source file
of the model, so that a kept plant is never older than its sources.
"""

import hashlib
import importlib.util
import os
import sys
import threading
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import numba

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.along import build_along
from pneu_rig_ros.model.dynamics import RightHandSide
from pneu_rig_ros.model.layout import STATE_SIZE
from pneu_rig_ros.model.right_hand_side import (
    build_mechanics,
    build_readings,
    build_right_hand_side,
    collect,
)
from pneu_rig_ros.model.run import build_run

_HEADER = '''"""Compiled plant with effects {effects}; made by pneu_rig_ros, may be deleted."""

from numba import njit

from pneu_rig_ros.model import assembly

built = assembly.build({effects!r})
'''
_FUNCTION = """
_{name} = built.{name}


@njit(cache=True, error_model='numpy', nogil=True, no_cfunc_wrapper=True)
def {name}({arguments}):
    _{name}({arguments})
"""
_ARGUMENTS = {
    'right_hand_side': 'time, point, model',
    'run': 'carry, interval, first, voltages, actions, measured, rests, states, extras, '
    'tolerance, longest, model',
    'readings': 'times, states, out, scratch, model',
    'along': 'interval, measured, velocity, contacts, voltages, out, states, carry, model',
}
"""Of the functions of an :class:`Assembly`."""


class Assembly(NamedTuple):
    """The compiled functions of one plant."""

    right_hand_side: RightHandSide
    run: Callable[..., None]
    readings: Callable[..., None]
    along: Callable[..., None]


def build(effects: Sequence[str]) -> Assembly:
    """Return the functions with the named effects, not yet cached."""
    contributions = collect([library.load(name) for name in effects], STATE_SIZE)
    mechanics = build_mechanics(contributions)
    right_hand_side = build_right_hand_side(contributions, mechanics)
    return Assembly(
        right_hand_side,
        build_run(right_hand_side),
        build_readings(contributions),
        build_along(right_hand_side, mechanics),
    )


_ASSEMBLING = threading.Lock()


def assemble(effects: tuple[str, ...]) -> Assembly:
    """Return the compiled, disk-cached functions with the named effects, of any shape."""
    with _ASSEMBLING:  # threads that start together would each compile a plant of their own
        return _assemble(effects)


@cache
def _assemble(effects: tuple[str, ...]) -> Assembly:
    module = _module(effects)
    return Assembly(*(getattr(module, name) for name in Assembly._fields))


_SOURCES = b''.join(path.read_bytes() for path in sorted(Path(__file__).parent.rglob('*.py')))
"""The package as it is imported: what changes on the disk later is not what is compiled."""


def cache_folder() -> Path:
    """Return where compiled plants are kept: ``$XDG_CACHE_HOME/pneu_rig_ros``."""
    home = os.environ.get('XDG_CACHE_HOME')
    return (Path(home) if home else Path.home() / '.cache') / 'pneu_rig_ros'


def _module(effects: tuple[str, ...]) -> ModuleType:
    functions = (_FUNCTION.format(name=n, arguments=a) for n, a in _ARGUMENTS.items())
    text = _HEADER.format(effects=effects) + ''.join(functions)
    return kept_module(f'plant_{_fingerprint(text)}', text)


def kept_module(name: str, text: str) -> ModuleType:
    """Return a module of the cache folder, written there if it is missing."""
    path = cache_folder() / f'{name}.py'
    if not path.exists():
        _write(path, text)
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f'{path} cannot be imported')
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def _write(path: Path, text: str) -> None:
    """Write a file atomically, also if other processes start now."""
    partial = path.with_suffix(f'.{os.getpid()}_{threading.get_ident()}')
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        partial.write_text(text)
        partial.replace(path)
    except OSError as error:
        raise RigError(
            f'{path.parent}: the compiled plant cannot be kept there ({error.strerror}); '
            f'set XDG_CACHE_HOME to a folder that can be written'
        ) from None


def _fingerprint(text: str) -> str:
    key = f'{sys.version} {numba.__version__} {text}'.encode()
    return hashlib.sha256(key + _SOURCES).hexdigest()[:16]
