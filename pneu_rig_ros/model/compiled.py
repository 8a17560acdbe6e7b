"""The compiler switch used by every function of the model."""

import secrets
from collections.abc import Callable, Iterator
from typing import Any, TypeVar, cast

import numba
from numba.core.bytecode import FunctionIdentity

Function = TypeVar('Function', bound=Callable[..., object])


OPTIONS: dict[str, Any] = {
    'error_model': 'numpy', 'nogil': True, '_nrt': False, 'forceinline': True,
}  # fmt: skip
"""Of the compiler, see :func:`compiled`."""


class _NeverTwice(Iterator[int]):
    """
    Numbers that no other process draws, nor a forked one.

    Numba tells functions of one name and one signature apart in machine code by a number that
    each process counts from 1. Plants kept on disk by different processes would so hold
    different functions under one symbol, and a process that loads both would run the first of
    them in place of the other without a word (Numba issue 10486).
    """

    def __next__(self) -> int:
        return secrets.randbits(64)


FunctionIdentity._unique_ids = _NeverTwice()  # type: ignore[assignment]


def plain(function: Function) -> Function:
    """Return the Python function behind a compiled one, for a single call at the start."""
    return cast(Function, getattr(function, 'py_func', function))


def compiled(function: Function) -> Function:
    """
    Compile a building block of the plant with Numba.

    Blocks are not cached one by one: Numba would keep a stale caller when only a callee's file
    changed. The assembled plant is cached as a whole, see ``assembly``. Of the options,

    - ``error_model='numpy'`` leaves out the checks for a division by zero, which validation has
      made impossible;
    - ``_nrt=False`` leaves out the counting of references to arrays, which took six sevenths of
      the time; a block may then not allocate any, which Numba says when it compiles;
    - ``forceinline`` makes one function of the blocks, which else hand on all parameters of all
      effects by value: another quarter, half with every effect of the library.
    """
    return cast(Function, numba.njit(**OPTIONS)(function))


INNER: dict[str, Any] = {**OPTIONS, 'no_cpython_wrapper': True, 'no_cfunc_wrapper': True}
"""Of a block that compiled code alone calls."""


def inner(function: Function) -> Function:
    """
    Compile a block that compiled code alone calls.

    The code that would take its parameters from Python is left out: all those of the plant, which
    took three quarters of the time of compiling a small block.
    """
    return cast(Function, numba.njit(**INNER)(function))


def called(function: Function) -> Function:
    """Compile a block that is called in place of made part of its callers: long, seldom run."""
    return cast(Function, numba.njit(**{**INNER, 'forceinline': False})(function))
