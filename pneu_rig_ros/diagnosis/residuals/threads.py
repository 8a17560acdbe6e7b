"""Work on several runs at a time, a thread each: compiled code releases the interpreter lock."""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any, TypeVar

Result = TypeVar('Result')


@cache
def _threads() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(os.cpu_count() or 1, 'run')


def map_runs(function: Callable[..., Result], *arguments: Iterable[Any]) -> list[Result]:
    """
    Return the results of a function for each run, in order, whatever the number of threads.

    The function may not call this one: all threads could wait for each other.

    :param arguments: of each call, one iterable a parameter
    """
    return list(_threads().map(function, *(list(values) for values in arguments)))
