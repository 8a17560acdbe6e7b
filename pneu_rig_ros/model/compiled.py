"""The compiler switch used by every function of the model."""

import secrets
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, TypeVar, cast

import numba
from numba.core.bytecode import FunctionIdentity
from numba.extending import register_jitable

from pneu_rig_ros.model.block_compiler import BlockCompiler

Function = TypeVar('Function', bound=Callable[..., object])

OPTIONS: dict[str, Any] = {
    'error_model': 'numpy',
    'nogil': True,
    '_nrt': False,
    'no_cpython_wrapper': True,
    'no_cfunc_wrapper': True,
    'pipeline_class': BlockCompiler,
}
"""Of the compiler, see :func:`compiled`."""


class _UniqueNumbers(Iterator[int]):
    """
    Numbers that no other process draws, nor a forked one.

    Numba distinguishes functions of one name and signature in machine code by a number that each
    process counts from 1. Plants cached by different processes would therefore hold different
    functions under one symbol, and a process that loads both would silently run the first of
    them in place of the other (Numba issue 10486).
    """

    def __next__(self) -> int:
        return secrets.randbits(64)


FunctionIdentity._unique_ids = _UniqueNumbers()


def compiled(function: Function) -> Function:
    """
    Let compiled code compile a building block of the plant; Python calls it as it is written.

    Blocks are not cached one by one: Numba would keep a stale caller when only a callee's file
    changed. The assembled plant is cached as a whole, see ``assembly``. Of the options,

    - ``error_model='numpy'`` omits the checks for a division by zero, which validation has made
      impossible;
    - ``_nrt=False`` omits the counting of references to arrays, which took six sevenths of the
      run time; a block may then not allocate any, which Numba reports when it compiles;
    - ``no_cpython_wrapper`` and ``no_cfunc_wrapper`` omit the code that takes the parameters of
      the whole plant from Python, three quarters of the time to compile a small block;
    - ``pipeline_class`` omits the machine code of the block by itself, a third of the time to
      compile a plant, see ``block_compiler``;
    - ``forceinline`` makes one function of the blocks, which would otherwise pass on the
      model and the signals by value: another quarter of the run time.
    """
    block: Function = register_jitable(**OPTIONS, forceinline=True)(function)
    return block


def called(function: Function) -> Function:
    """
    Compile a block as a function of its own, as is best for long code that seldom runs.

    Left to itself, Numba gives it the ``forceinline`` of the function that calls it.
    """
    block: Function = register_jitable(**OPTIONS, forceinline=False)(function)
    return block


def inner(function: Function) -> Function:
    """Compile a block that compiled code alone calls, such as one made for a set of effects."""
    return cast(Function, numba.njit(**OPTIONS, forceinline=True)(function))


def inner_called(function: Function) -> Function:
    """Compile such a block as a function of its own, see :func:`called`."""
    return cast(Function, numba.njit(**OPTIONS, forceinline=False)(function))


def in_turn(
    name: str, arguments: str, first: str, steps: Iterable[str], blocks: Mapping[str, Any]
) -> Callable[..., Any]:
    """
    Return a function that does one step after the other, and returns what they leave.

    Compiled code cannot loop over functions, and a chain of them, each with a function of its
    own, takes a time to compile that grows with the square of their number.

    :param name: of the function
    :param arguments: of it, by name
    :param first: statement that defines ``total``
    :param steps: statements that change it
    :param blocks: what the steps call, by name
    """
    lines = '\n    '.join([first, *steps, 'return total'])
    space = dict(blocks)
    exec(f'def {name}({arguments}):\n    {lines}\n', space)
    function: Callable[..., Any] = space[name]
    return function
