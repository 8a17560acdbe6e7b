"""Compiled functions of the second plant, kept on the disk until one of its files changes."""

import hashlib
import inspect
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba.extending import register_jitable

from pneu_rig_ros.model.assembly import kept_module
from pneu_rig_ros.model.block_compiler import BlockCompiler

OPTIONS: dict[str, Any] = {
    'no_cpython_wrapper': True,
    'no_cfunc_wrapper': True,
    'pipeline_class': BlockCompiler,
}
"""Of what is compiled into kept functions alone."""

_SOURCES = b''.join(path.read_bytes() for path in sorted(Path(__file__).parent.glob('*.py')))
"""All of them: Numba alone would keep a function when only one that it calls has changed."""


def block(function: Callable[..., Any]) -> Callable[..., Any]:
    """
    Return what kept functions call, compiled with them; Python runs it as it is written.

    Neither wrappers for calls from Python nor machine code of the block alone are made.
    """
    registered: Callable[..., Any] = register_jitable(**OPTIONS)(function)
    return registered


def kept(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return the function compiled and kept, with all that it calls."""
    name, module = function.__name__, function.__module__
    # what the kept module imports
    vars(sys.modules[module])[f'_{name}'] = numba.njit(**OPTIONS)(function)
    arguments = ', '.join(inspect.signature(function).parameters)
    text = (
        f'"""Compiled {name} of {module}; made by its tests, may be deleted."""\n\n'
        f'from numba import njit\n\nfrom {module} import _{name}\n\n\n'
        f'@njit(cache=True)\ndef {name}({arguments}):\n    return _{name}({arguments})\n'
    )
    key = hashlib.sha256(f'{numba.__version__} {text}'.encode() + _SOURCES).hexdigest()[:16]
    compiled: Callable[..., Any] = getattr(kept_module(f'second_{name}_{key}', text), name)
    return compiled
