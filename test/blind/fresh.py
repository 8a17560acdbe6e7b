"""
Trials that are drawn from a seed: what is reported of the workflow comes from these alone.

They have the parts of ``trials``, at strengths, cylinders and amounts that are drawn, and a part
for each system that is not a whole rig, see ``systems``; among each part's trials are some in
which nothing is hidden. A trial's key holds the seed.
"""

import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial

import numpy as np
from numpy.random import Generator

from pneu_rig_ros.scenarios.hidden import CYLINDERS, EFFECTS, Secret

from .constants import LAWS
from .places import GAS, SENSOR
from .sensors import drawn_gains
from .systems import SYSTEMS, sizes
from .trials import NOISES, PAIRS, PARAMETERS, Trial, alike, join, of_rig, shuffled, wrong

SEED = 36
EARLIER = 20
"""Seed of the trials that code of earlier revisions answered as well."""
FRESH = 'fresh'
"""Keys begin with it."""
ONE_PRESSURE = 'one_pressure'
"""A whole rig whose second pressure is not measured."""
ADDED = (
    'porous_leak',
    'natural_convection',
    'pressure_power_friction',
    'travel_dependent_friction',
    'time_dependent_friction',
    'bore_taper',
)
FURTHER = ('jet_convection', 'gas_mass_heat_transfer')
LATEST = ('direction_dependent_viscous_friction',)
NEWEST = (
    'line_resistance',
    'spool_rate_limit',
    'local_friction',
    'direction_dependent_static_friction',
    'forced_convection',
    'supply_tank',
    'seal_elasticity',
    'local_piston_leak',
)
"""Effects that came later, and later still: drawn apart, so that earlier draws stay the same."""
SETTLED = tuple(name for name in EFFECTS if name not in (*ADDED, *LATEST, *NEWEST, *FURTHER))
RIG_PARTS = ('single', 'none', 'parameter', 'pair', 'triple', 'removed', 'uncalibrated')
SYSTEM_PARTS = (*SYSTEMS, ONE_PRESSURE)
FRESH_PARTS = (*RIG_PARTS, *SYSTEM_PARTS)
SINGLES, PAIRED, TRIPLED, REMOVED, CALIBRATIONS = 30, 10, 6, 12, 7
NOISY, NOISY_NOTHING = 8, 2
"""Trials at each other multiple of the noise, with one effect hidden and with nothing."""
WRONG = {1: 10, 2: 3, 3: 2}
"""Number of wrong parameters -> trials."""
NOTHING, UNCALIBRATED_NOTHING, SYSTEM_NOTHING = 14, 4, 2
SYSTEM_TRIALS = {
    'sealed_chambers': 9,
    'leaking_chamber': 4,
    'seal_bench': 8,
    'valve_block': 11,
    ONE_PRESSURE: 6,
}
"""System -> trials in which something is hidden."""
IN_CHAMBER_1 = (
    'supply_droop',
    'chamber_leak',
    'valve_null_leak',
    'wall_heat_transfer',
    'line_lag',
    'valve_lag',
    'spool_hysteresis',
    'nonlinear_opening',
)
"""Effects that show in chamber 1 and need no pressure of chamber 2."""


def drawn(seed: int = SEED) -> list[Trial]:
    """Return the trials of a seed, in an order such that any first part is a fair sample."""
    makers: tuple[Callable[[int, Generator], Iterable[Trial]], ...] = (
        partial(_singles, names=SETTLED, count=SINGLES),
        _none,
        _parameter,
        _pair,
        _removed,
        _uncalibrated,
        _systems,
        _one_pressure,
        partial(_singles, names=ADDED, count=len(ADDED)),
        _noisy,
        _triple,
        partial(_singles, names=LATEST),
        partial(_singles, names=NEWEST),
        partial(_singles, names=FURTHER),
    )
    return shuffled(
        [
            trial
            for place, make in enumerate(makers)
            for trial in make(seed, np.random.default_rng([seed, place]))
        ]
    )


def some_of(names: Sequence[str], count: int, random: Generator) -> list[str]:
    """Draw names, each as often as the others or once more."""
    rounds = -(-count // len(names))
    return [str(name) for _ in range(rounds) for name in random.permutation(names)][:count]


def _alone(names: Sequence[str], count: int, random: Generator) -> list[tuple[str, ...]]:
    """Draw groups of one name, each name as often as the others or once more."""
    return [(name,) for name in some_of(names, count, random)]


def _grade(random: Generator) -> float:
    return float(random.uniform(0.0, 2.0))


def key_of(seed: int, part: str, what: Sequence[str] | str, cylinder: str, number: int) -> str:
    """Return the key of a trial in which names, or a name, are hidden."""
    name = what if isinstance(what, str) else '+'.join(what) or 'nothing'
    return '/'.join((FRESH, str(seed), part, name, cylinder, str(number)))


def _hiding(
    seed: int, part: str, groups: Sequence[tuple[str, ...]], random: Generator
) -> Iterator[Trial]:
    """Yield a trial for each group of effects, at a grade drawn for each of them."""
    for number, names in enumerate(groups):
        cylinder = str(random.choice(CYLINDERS))
        grades = [_grade(random) for _ in names]
        secret = join(*(of_rig(n, cylinder, g) for n, g in zip(names, grades, strict=True)))
        key = key_of(seed, part, names, cylinder, number)
        strength = '+'.join(f'{grade:.2f}' for grade in grades)
        yield Trial(key, part, cylinder, 1.0, secret, names, strength)


def _singles(
    seed: int, random: Generator, names: Sequence[str], count: int = 0
) -> Iterator[Trial]:
    """Hide one of some effects at a time: so many that are drawn, or all in their order."""
    groups = _alone(names, count, random) if count else [(name,) for name in names]
    yield from _hiding(seed, 'single', groups, random)


def _noisy(seed: int, random: Generator) -> Iterator[Trial]:
    names = [name for name in EFFECTS if name not in (*LATEST, *NEWEST, *FURTHER)]
    for noise in NOISES[1:]:
        groups = _alone(names, NOISY, random)
        for trial in _hiding(seed, f'single_{noise:g}', groups, random):
            yield trial._replace(part='single', noise=noise)
        for trial in _hiding(seed, f'none_{noise:g}', NOISY_NOTHING * [()], random):
            yield trial._replace(part='none', noise=noise)


def _pair(seed: int, random: Generator) -> Iterator[Trial]:
    chosen = random.permutation(len(PAIRS))[:PAIRED]
    yield from _hiding(seed, 'pair', [PAIRS[place] for place in chosen], random)


def _triple(seed: int, random: Generator) -> Iterator[Trial]:
    """Hide an effect on the gas, one on the forces, and any third one."""
    gas = [name for name in SETTLED if name in GAS]
    forces = [name for name in SETTLED if name not in GAS | SENSOR]
    groups = []
    for _ in range(TRIPLED):
        two = str(random.choice(gas)), str(random.choice(forces))
        groups.append((*two, str(random.choice([n for n in SETTLED if n not in two]))))
    yield from _hiding(seed, 'triple', groups, random)


def _removed(seed: int, random: Generator) -> Iterator[Trial]:
    for trial in _hiding(seed, 'removed', _alone(SETTLED, REMOVED, random), random):
        yield trial._replace(without=alike(trial.names[0]))


def _none(seed: int, random: Generator) -> Iterator[Trial]:
    for number, law in enumerate(some_of(LAWS, NOTHING, random)):
        cylinder, both = str(random.choice(CYLINDERS)), {'friction.model': law}
        key = key_of(seed, 'none', law, cylinder, number)
        yield Trial(key, 'none', cylinder, 1.0, Secret({}, both, both), ())


def _parameter(seed: int, random: Generator) -> Iterator[Trial]:
    counts = [count for count, times in WRONG.items() for _ in range(times)]
    alone = some_of(PARAMETERS, WRONG[1], random)
    for number, count in enumerate(counts):
        several = sorted(random.choice(PARAMETERS, count, replace=False).tolist())
        names = (alone[number],) if count == 1 else tuple(map(str, several))
        cylinder = str(random.choice(CYLINDERS))
        key = key_of(seed, 'parameter', names, cylinder, number)
        secret = Secret({}, wrong(names, cylinder, key), {})
        yield Trial(key, 'parameter', cylinder, 1.0, secret, names)


def _uncalibrated(seed: int, random: Generator) -> Iterator[Trial]:
    # to sensors whose slopes are open anyway, position_scale is nothing else
    known = [name for name in SETTLED if name != 'position_scale']
    groups = [*_alone(known, CALIBRATIONS, random), *UNCALIBRATED_NOTHING * [()]]
    for trial in _hiding(seed, 'uncalibrated', groups, random):
        yield trial._replace(gains=drawn_gains(zlib.crc32(trial.key.encode())))


def _systems(seed: int, random: Generator) -> Iterator[Trial]:
    for name, system in SYSTEMS.items():
        groups = [*_alone(system.hidden, SYSTEM_TRIALS[name], random), *SYSTEM_NOTHING * [()]]
        for number, names in enumerate(groups):
            key, grade = key_of(seed, name, names, '-', number), _grade(random)
            secret, strength = Secret({}, {}, {}), ''
            if names:
                secret = system.hide(names[0], grade, sizes(system, key))
                strength = f'{grade:.2f}'
            yield Trial(key, name, '', 1.0, secret, names, strength)


def _one_pressure(seed: int, random: Generator) -> Iterator[Trial]:
    groups = _alone(IN_CHAMBER_1, SYSTEM_TRIALS[ONE_PRESSURE], random)
    yield from _hiding(seed, ONE_PRESSURE, [*groups, *SYSTEM_NOTHING * [()]], random)
