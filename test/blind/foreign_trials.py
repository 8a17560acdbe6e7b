"""
Trials in a world that is not the library's, drawn from a seed when they are asked for.

``foreign``: a form whose mechanism the library has under another formula. ``foreign_unknown``: one
that it does not have. ``foreign_pairs``, ``triples``: two, three of them at a time. ``nuisance``:
a strong cause among weak ones, sensors, stamps, air and supply that are off, friction that wears;
``nuisance_none``: the same without a cause. ``conditions``: something is not as stated.
``second``, ``second_unknown``: as the first two, of the second list of forms.
"""

import zlib
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.random import Generator

from pneu_rig_ros.scenarios.hidden import CYLINDERS, LAWS, Changes, Secret

from .circumstances import AS_STATED, WRONG, Circumstances, drawn_wrong
from .foreign import FORMS, KNOWN, NEVER_WEAK, UNKNOWN
from .forms import ALL, ALL_STRENGTHS, mechanism
from .fresh import SETTLED, key_of, some_of
from .second import SECOND_KNOWN, SECOND_UNKNOWN
from .sensors import drawn_gains
from .trials import Trial, join, of_rig, shuffled

COUNTS = {
    'foreign': 84,
    'foreign_unknown': 60,
    'nuisance': 60,
    'nuisance_none': 60,
    'conditions': 63,
    'foreign_pairs': 60,
    'triples': 60,
    'second': 44,
    'second_unknown': 12,
}
"""Part -> trials of a seed."""
FOREIGN_PARTS = tuple(COUNTS)
ALONE = {
    'foreign': KNOWN,
    'foreign_unknown': UNKNOWN,
    'second': SECOND_KNOWN,
    'second_unknown': SECOND_UNKNOWN,
}
"""Part in which one form is hidden alone -> the forms."""
SECOND_PARTS = 'second', 'second_unknown'
"""Parts of the second list of forms."""
SEVERAL_FORMS = 'foreign_pairs', 'triples'
"""Parts in which several forms are hidden together."""
FIRST_STREAM = 100
"""Of the random numbers; those of the parts of ``fresh`` are below."""
WEAKEST = 3.0
"""Multiple of the noise by which the weak strength of a form shows."""
NUISANCES = (3, 5)
WEAK = (0.5, 1.5)
"""Number of nuisances, and by what multiple of the noise each shows."""
STRONG = 0.5
"""Least place of a strong cause between weak and strong, in logarithms: 13 times the noise."""
AIR = (288.15, 303.15)
"""[K]"""


def drawn_foreign(seed: int, parts: Sequence[str] = FOREIGN_PARTS) -> list[Trial]:
    """Return the trials of a seed, in an order such that any first part is a fair sample."""
    makers = {
        'foreign': _alone,
        'foreign_unknown': _alone,
        'nuisance': _nuisance,
        'nuisance_none': _nuisance_none,
        'conditions': _conditions,
        'foreign_pairs': _several,
        'triples': _several,
        'second': _alone,
        'second_unknown': _alone,
    }
    return shuffled(
        [
            trial
            for place, (part, make) in enumerate(makers.items())
            if part in parts
            for trial in make(seed, part, np.random.default_rng([seed, FIRST_STREAM + place]))
        ]
    )


def hide_form(
    name: str, cylinder: str, random: Generator, factor: float | None = None, least: float = 0.0
) -> Secret:
    """
    Return what hides a form, its strength and shape drawn.

    :param factor: multiple of its weak strength; drawn between weak and strong if not said
    :param least: 0 for all from weak to strong, 0.5 for the stronger half
    """
    form = ALL[name]
    weak, strong = ALL_STRENGTHS[name][CYLINDERS.index(cylinder)]
    share = float(random.uniform(least, 1.0))
    strength = weak * factor if factor else weak * (strong / weak) ** share
    shape = {key: float(random.uniform(*bounds)) for key, bounds in form.shape.items()}
    base: Changes = {'friction.model': form.base} if form.base else {}
    return Secret({name: {'strength': strength, **shape}}, dict(base), dict(base))


def together(names: Sequence[str]) -> bool:
    """Whether forms can be in one rig: each in a place of its own, under one friction law."""
    slots = [slot for name in names for slot in _slots(name)]
    bases = {ALL[name].base for name in names}
    void = 'coulomb_viscous' in bases and 'outward_excess' in names  # that law has no F_s
    return len(set(slots)) == len(slots) and len(bases - {''}) <= 1 and not void


def _slots(name: str) -> list[str]:
    form = ALL[name]
    return [form.slot or name, *([form.also[0]] if form.also else [])]


def _trial(seed: int, part: str, names: tuple[str, ...], number: int, random: Generator) -> Trial:
    cylinder = str(random.choice(CYLINDERS))
    secret = join(*(hide_form(name, cylinder, random) for name in names))
    key = key_of(seed, part, names, cylinder, number)
    strength = '+'.join(f'{secret.effects[name]["strength"]:.2g}' for name in names)
    return Trial(key, part, cylinder, 1.0, secret, names, strength)


def _alone(seed: int, part: str, random: Generator) -> Iterator[Trial]:
    for number, name in enumerate(some_of(ALONE[part], COUNTS[part], random)):
        yield _trial(seed, part, (name,), number, random)


def _group(size: int, random: Generator) -> tuple[str, ...]:
    """Draw forms of different mechanisms that can be in one rig."""
    while True:
        names = tuple(str(name) for name in random.choice(KNOWN, size, replace=False))
        mechanisms = [word for name in names for word in FORMS[name].mechanism]
        if together(names) and len(set(mechanisms)) == len(mechanisms):
            return names


def _several(seed: int, part: str, random: Generator) -> Iterator[Trial]:
    """Yield triples, or pairs on one balance and on two by turns."""
    size = 2 if part == 'foreign_pairs' else 3
    for number in range(COUNTS[part]):
        names = _group(size, random)
        while size == 2 and len({FORMS[name].balance for name in names}) != 1 + number % 2:
            names = _group(size, random)
        yield _trial(seed, part, names, number, random)


def _world(
    cylinder: str, cause: Secret, names: tuple[str, ...], random: Generator
) -> tuple[Secret, Circumstances]:
    """Return a cause among nuisances that are drawn, and the circumstances."""
    taken = {slot for name in names if name in FORMS for slot in _slots(name)}
    busy = {word for name in names for word in mechanism(name)}
    weak: list[str] = []
    wanted = int(random.integers(NUISANCES[0], NUISANCES[1] + 1))
    for name in random.permutation([name for name in FORMS if name not in NEVER_WEAK]):
        form = FORMS[str(name)]
        free = together([*weak, str(name)]) and not taken & set(_slots(str(name)))
        if free and not form.base and not busy & set(form.mechanism) and len(weak) < wanted:
            weak.append(str(name))
    factors = random.uniform(*WEAK, len(weak)) / WEAKEST
    others = [
        hide_form(name, cylinder, random, float(factor))
        for name, factor in zip(weak, factors, strict=True)
    ]
    air = {'gas.supply_temperature': float(random.uniform(*AIR))}
    secret = join(cause, *others, Secret({}, air, {}))
    return secret, AS_STATED._replace(
        supply=1.0 + float(random.uniform(-0.02, 0.02)),
        jitter=float(random.uniform(0.01, 0.03)),
        lost=0.01,
        wear=float(random.uniform(0.0, 0.02)),
    )


def _nuisance(seed: int, part: str, random: Generator) -> Iterator[Trial]:
    """Yield strong causes, foreign and of the library by turns, among weak ones."""
    effects = [name for name in SETTLED if name not in LAWS]
    foreign, own = (some_of(names, COUNTS[part], random) for names in (KNOWN, effects))
    for number in range(COUNTS[part]):
        name = (foreign, own)[number % 2][number]
        cylinder = str(random.choice(CYLINDERS))
        if name in FORMS:
            cause = hide_form(name, cylinder, random, least=STRONG)
        else:
            cause = of_rig(name, cylinder, float(random.uniform(1.0, 2.0)))
        yield _in_world(seed, part, cylinder, cause, (name,), number, random)


def _nuisance_none(seed: int, part: str, random: Generator) -> Iterator[Trial]:
    for number in range(COUNTS[part]):
        cylinder, nothing = str(random.choice(CYLINDERS)), Secret({}, {}, {})
        yield _in_world(seed, part, cylinder, nothing, (), number, random)


def _in_world(
    seed: int,
    part: str,
    cylinder: str,
    cause: Secret,
    names: tuple[str, ...],
    number: int,
    random: Generator,
) -> Trial:
    key = key_of(seed, part, names, cylinder, number)
    secret, circumstances = _world(cylinder, cause, names, random)
    gains = drawn_gains(zlib.crc32(key.encode()))
    return Trial(key, part, cylinder, 1.0, secret, names, gains=gains, circumstances=circumstances)


def _conditions(seed: int, part: str, random: Generator) -> Iterator[Trial]:
    for number, name in enumerate(some_of(tuple(WRONG), COUNTS[part], random)):
        cylinder = str(random.choice(CYLINDERS))
        key = key_of(seed, part, name, cylinder, number)
        wrong, nothing = drawn_wrong(name, cylinder, random), Secret({}, {}, {})
        yield Trial(key, part, cylinder, 1.0, nothing, (name,), circumstances=wrong)
