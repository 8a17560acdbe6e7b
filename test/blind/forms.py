"""The forms of both lists, and their numbers in the plant."""

from collections.abc import Mapping

import numpy as np

from . import constants as at
from .foreign import FORMS, Form
from .foreign_strengths import STRENGTHS
from .second import SECOND
from .second_strengths import SECOND_STRENGTHS

ALL: dict[str, Form] = {**FORMS, **SECOND}
"""Name -> form."""
ALL_STRENGTHS = {**STRENGTHS, **SECOND_STRENGTHS}
"""Form -> weak and strong, for cylinder 1, 2, 3."""
NUMBERS = frozenset(
    f'{name}.{number}' for name, form in ALL.items() for number in ('strength', *form.shape)
)
"""What can be hidden, form.number."""


def is_form(name: str) -> bool:
    """Whether form.number, or a form, is one of these."""
    return name.split('.')[0] in ALL


def mechanism(name: str) -> tuple[str, ...]:
    """Return the names that are right for what is hidden; an effect's is its own."""
    return ALL[name].mechanism if name in ALL else (name,)


def numbers(hidden: Mapping[str, float]) -> np.ndarray:
    """
    Return the flat numbers of the forms in the plant, none where there are none.

    :param hidden: form.number -> value; numbers of other things are not read
    """
    names = {name.split('.')[0] for name in hidden if name in NUMBERS}
    inside = sorted(name for name in names if ALL[name].slot)
    flat = np.zeros(at.WIDTH * len(at.SLOTS))
    for name in inside:
        form, strength = ALL[name], hidden.get(f'{name}.strength', 0.0)
        place = at.WIDTH * at.SLOTS.index(form.slot)
        assert not flat[place], f'{name}: two forms in one place'
        shape = [hidden[f'{name}.{number}'] for number in form.shape]
        flat[place : place + 2 + len(shape)] = form.code, strength, *shape
        if form.also:
            place = at.WIDTH * at.SLOTS.index(form.also[0])
            flat[place : place + 2] = form.also[1], strength
    return flat if inside else np.empty(0)


def states(numbers: np.ndarray) -> int:
    """Return how many numbers the state has of a plant with known and foreign effects."""
    if numbers.size == at.FOREIGN:
        return at.STATES
    codes = numbers[at.FOREIGN :: at.WIDTH]
    return at.SECOND_STATES if codes.max() > at.SECOND_CODE else at.FOREIGN_STATES
