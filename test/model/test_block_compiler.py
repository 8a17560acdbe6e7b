"""Functions that are only compiled into others have no machine code of their own."""

import numba
import pytest

from pneu_rig_ros.model.block_compiler import BlockLibrary
from pneu_rig_ros.model.compiled import inner


@inner
def double(value: float) -> float:
    return 2.0 * value


@numba.njit
def double_twice(value: float) -> float:
    return double(double(value))


def test_block_is_linked_into_its_callers() -> None:
    assert double_twice(1.5) == 6.0
    (compiled,) = double.overloads.values()
    assert isinstance(compiled.library, BlockLibrary)
    (caller,) = double_twice.overloads.values()
    assert not isinstance(caller.library, BlockLibrary)


def test_block_is_not_called_from_python() -> None:
    double_twice(1.5)
    with pytest.raises((TypeError, KeyError)):
        double(1.5)
