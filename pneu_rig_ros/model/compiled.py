"""The compiler switch used by every function of the model."""

from collections.abc import Callable
from typing import TypeVar, cast

import numba

Function = TypeVar('Function', bound=Callable[..., object])


def plain(function: Function) -> Function:
    """Return the Python function behind a compiled one, for a single call at the start."""
    return cast(Function, getattr(function, 'py_func', function))


def compiled(function: Function) -> Function:
    """
    Compile a building block of the plant with Numba.

    Blocks are not cached one by one: Numba would keep a stale caller when only a callee's file
    changed. The assembled plant is cached as a whole, see ``assembly``. ``error_model='numpy'``
    leaves out the checks for a division by zero, which validation has made impossible.
    """
    return cast(Function, numba.njit(error_model='numpy', nogil=True)(function))
