"""
Work on several runs at a time, one thread each: what is compiled runs without the interpreter.

The results are those of one run after the other.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any, TypeVar

Result = TypeVar('Result')


@cache
def _threads() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(os.cpu_count() or 1, 'run')


def map_runs(function: Callable[..., Result], *of_each: Iterable[Any]) -> list[Result]:
    """
    Return what a function returns for each run, in their order.

    The function may not itself work on several runs: all threads could wait for one.

    :param of_each: its arguments, one of each run
    """
    return list(_threads().map(function, *(list(one) for one in of_each)))
