"""
Optional physical effects, one a file, and those that add empirical terms.

A file in this folder is an effect, by its ``contribution``; its name is the file's name. Nothing
else has to be changed to add one.
"""

import importlib
import pkgutil
from functools import cache
from typing import Any

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.effect import Effect
from pneu_rig_ros.model.empirical_effects import EFFECTS as EMPIRICAL_SUMS
from pneu_rig_ros.model.empirical_memory import EFFECTS as EMPIRICAL_MEMORIES
from pneu_rig_ros.model.quantity import unknown

EMPIRICAL = {**EMPIRICAL_SUMS, **EMPIRICAL_MEMORIES}


@cache
def names() -> tuple[str, ...]:
    """Return the names of all effects, sorted."""
    return tuple(sorted([*EMPIRICAL, *(module.name for module in pkgutil.iter_modules(__path__))]))


@cache
def load(name: str, where: str = 'effects') -> Effect:
    """
    Return the effect of that name.

    :param where: what an error begins with
    :raises RigError: when there is none, with the allowed names, or its file declares none
    """
    if name not in names():
        raise RigError(f'{where}: {unknown(name, names())}')
    if name in EMPIRICAL:
        return EMPIRICAL[name]
    effect = getattr(importlib.import_module(f'{__name__}.{name}'), 'contribution', None)
    if not isinstance(effect, Effect):
        raise RigError(f'{where}: {name}.py has no contribution that @Effect(...) decorates')
    return effect


def nulls() -> dict[str, Any]:
    """
    Return the parameters of all effects with which none acts, by name.

    Plants with these, and others in place of some, share their compiled code.
    """
    return {name: load(name).null for name in names()}


def causes() -> tuple[str, ...]:
    """Return the names of the effects that are causes, no mere descriptions, sorted."""
    return tuple(name for name in names() if not load(name).describes)


def cause(name: str, where: str) -> str:
    """
    Return the name of an effect that is a cause.

    :param where: what an error begins with
    :raises RigError: when it is none, with the allowed names
    """
    if name not in causes():
        raise RigError(f'{where}: {unknown(name, causes())}')
    return name
