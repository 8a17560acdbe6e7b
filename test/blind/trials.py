"""
The matrix for building: which trial hides what, on which cylinder, under how much noise.

Seven parts: ``single`` (each effect, three cylinders, three strengths, three levels of noise),
``none`` (nothing hidden, all friction laws), ``parameter`` (1 to 3 parameters wrong by up to
30 %), ``pair`` (two effects), ``removed`` (an effect that the library is made to lack), ``unseen``
(each effect at a strength drawn between weak and strong, each parameter wrong by another amount:
trials to be run once, with rules that are settled), ``uncalibrated`` (an effect or nothing hidden,
sensors wrong within their accuracy classes, of which the model tells). All draws follow from fixed
seeds, so a trial is the same whenever and in whatever order it is run. They were looked at while
the workflow was built; what is reported is drawn afresh, see ``fresh``.
"""

import zlib
from collections.abc import Iterator
from itertools import cycle, product
from typing import Any, NamedTuple

import numpy as np

from pneu_rig_ros.scenarios.hidden import CYLINDERS, EFFECTS, STRENGTHS, Changes, Secret, hide

from .circumstances import AS_STATED, Circumstances
from .constants import LAWS
from .sensors import CALIBRATED, Gains, drawn_gains
from .settings import settings

PARTS = ('single', 'none', 'parameter', 'pair', 'removed', 'unseen', 'uncalibrated')
NOISES = (1.0, 3.0, 10.0)

PARAMETERS = (
    'valve.intake_coefficient',
    'valve.exhaust_coefficient',
    'valve.intake_voltage',
    'valve.exhaust_voltage',
    'cylinder.cap_dead_volume',
    'cylinder.rod_dead_volume',
    'cylinder.moving_mass',
    'friction.breakaway_force',
    'friction.coulomb_force',
    'friction.stribeck_velocity',
    'friction.viscous_coefficient',
    'friction.element_stiffness',
    'friction.film_velocity',
    'friction.film_time_acceleration',
    'friction.film_time_deceleration',
    'friction.dwell_coefficient',
    'friction.dwell_exponent',
)
"""What may be wrong. ``film_time_dwell`` (36 s) cannot show in bags of 14 s."""

# two things that go wrong on one rig at a time: both in the gas, one in the gas and one in the
# friction, both in the friction, and one of them in a sensor
PAIRS = (
    ('supply_droop', 'chamber_leak'),
    ('supply_droop', 'wall_heat_transfer'),
    ('cross_piston_leak', 'valve_lag'),
    ('chamber_leak', 'spool_hysteresis'),
    ('wall_heat_transfer', 'line_lag'),
    ('wall_heat_transfer', 'cross_piston_leak'),
    ('nonlinear_opening', 'chamber_leak'),
    ('supply_droop', 'inclination'),
    ('cross_piston_leak', 'pressure_dependent_friction'),
    ('wall_heat_transfer', 'dwell_static_friction'),
    ('valve_lag', 'direction_dependent_friction'),
    ('valve_null_leak', 'load_spring'),
    ('spool_hysteresis', 'presliding_hysteresis'),
    ('nonlinear_opening', 'load_compliance'),
    ('chamber_leak', 'end_cushion'),
    ('dwell_static_friction', 'inclination'),
    ('dwell_static_friction', 'position_dependent_friction'),
    ('film_dynamics', 'direction_dependent_friction'),
    ('load_spring', 'pressure_dependent_friction'),
    ('inclination', 'friction_warm_up'),
    ('cross_piston_leak', 'position_scale'),
    ('pressure_offset', 'direction_dependent_friction'),
)
ALIKE = (
    ('chamber_leak', 'porous_leak'),
    (
        'wall_heat_transfer',
        'natural_convection',
        'forced_convection',
        'jet_convection',
        'gas_mass_heat_transfer',
    ),
    ('cross_piston_leak', 'local_piston_leak'),
    ('supply_droop', 'supply_tank'),
    ('presliding_hysteresis', 'seal_elasticity'),
    ('pressure_dependent_friction', 'pressure_power_friction'),
    (
        'direction_dependent_friction',
        'direction_dependent_viscous_friction',
        'direction_dependent_static_friction',
    ),
    ('position_dependent_friction', 'local_friction'),
    ('friction_warm_up', 'travel_dependent_friction', 'time_dependent_friction'),
    ('line_lag', 'line_resistance'),
    ('valve_lag', 'spool_rate_limit'),
)
"""Laws of one mechanism: a library that has one of them does not lack the mechanism."""


def join(*secrets: Secret) -> Secret:
    """Return all secrets together."""
    merged = Secret({}, {}, {})
    for secret in secrets:
        for own, other in zip(merged, secret, strict=True):
            own.update(other)
    return merged


class Trial(NamedTuple):
    """One trial; ``key`` tells all of it and is unique."""

    key: str
    part: str
    cylinder: str
    """'' for a system of its own sizes."""
    noise: float
    secret: Secret
    names: tuple[str, ...]
    """Right answer: effects, or parameters as section.name; none where nothing is hidden."""
    strength: str = ''
    """One of ``STRENGTHS``, or the grade that was drawn."""
    without: tuple[str, ...] = ()
    """Effects that the library is made to lack."""
    gains: Gains = CALIBRATED
    """Slopes of the sensors."""
    circumstances: Circumstances = AS_STATED
    """What is not as stated."""

    @property
    def seed(self) -> int:
        """Seed of the sensors' noise."""
        return zlib.crc32(self.key.encode())


def matrix(parts: tuple[str, ...] = PARTS) -> list[Trial]:
    """
    Return all trials of the parts.

    In an order that depends on nothing but their keys, so that any first part of them is a fair
    sample of the whole, the trials at the noise of the rig coming first.
    """
    makers = {
        'single': _single,
        'none': _none,
        'parameter': _parameter,
        'pair': _pair,
        'removed': _removed,
        'unseen': _unseen,
        'uncalibrated': _uncalibrated,
    }
    trials = [trial for part in parts for trial in makers[part]()]
    return shuffled(trials)


def shuffled(trials: list[Trial]) -> list[Trial]:
    """Return trials in an order that depends on nothing but their noise and their keys."""
    return sorted(trials, key=lambda trial: (trial.noise, zlib.crc32(trial.key[::-1].encode())))


def of_rig(effect: str, cylinder: str, strength: str | float) -> Secret:
    """Return what hides an effect in a shipped cylinder, by its strength or grade."""
    return hide(effect, cylinder, strength, settings(cylinder)['friction'])


def _trial(
    key: str, secret: Secret, names: tuple[str, ...] = (), strength: str = '', **more: Any
) -> Trial:
    """Return a trial, its part and cylinder being words of its key."""
    part, _, cylinder, *_ = key.split('/')
    return Trial(key, part, cylinder, more.pop('noise', 1.0), secret, names, strength, **more)


def _single() -> Iterator[Trial]:
    for effect, cylinder, strength, noise in product(EFFECTS, CYLINDERS, STRENGTHS, NOISES):
        key = f'single/{effect}/{cylinder}/{strength}/{noise:g}'
        yield _trial(key, of_rig(effect, cylinder, strength), (effect,), strength, noise=noise)


def _none() -> Iterator[Trial]:
    for cylinder, law, noise in product(CYLINDERS, LAWS, NOISES):
        for repeat in range(6 if noise == 1.0 else 2):
            both = {'friction.model': law}
            key = f'none/{law}/{cylinder}/{noise:g}/{repeat}'
            yield _trial(key, Secret({}, both, both), noise=noise)


def _pair() -> Iterator[Trial]:
    for names, cylinder in product(PAIRS, CYLINDERS):
        secret = join(*(of_rig(name, cylinder, 'medium') for name in names))
        yield _trial(f'pair/{"+".join(names)}/{cylinder}/1', secret, names, 'medium')


def _removed() -> Iterator[Trial]:
    for effect, cylinder in product(EFFECTS, CYLINDERS):
        key, secret = f'removed/{effect}/{cylinder}/1', of_rig(effect, cylinder, 'medium')
        yield _trial(key, secret, (effect,), 'medium', without=alike(effect))


def alike(effect: str) -> tuple[str, ...]:
    """Return the effects that are laws of the same mechanism, itself among them."""
    return next((group for group in ALIKE if effect in group), (effect,))


def _parameter() -> Iterator[Trial]:
    for cylinder in CYLINDERS:
        draws: set[tuple[str, ...]] = {(name,) for name in PARAMETERS}
        random = np.random.default_rng(int(cylinder[-1]))
        for count in 8 * (2, 3):
            draws.add(tuple(sorted(random.choice(PARAMETERS, count, replace=False).tolist())))
        for names in sorted(draws):
            key = f'parameter/{"+".join(names)}/{cylinder}/1'
            yield _trial(key, Secret({}, wrong(names, cylinder, key), {}), names)


def _unseen() -> Iterator[Trial]:
    for cylinder in CYLINDERS:
        for effect in EFFECTS:
            key = f'unseen/{effect}/{cylinder}/1'
            grade = float(np.random.default_rng(zlib.crc32(key.encode())).uniform(0.0, 2.0))
            yield _trial(key, of_rig(effect, cylinder, grade), (effect,), f'{grade:.2f}')
        for name in PARAMETERS:
            key = f'unseen/{name}/{cylinder}/1'
            yield _trial(key, Secret({}, wrong((name,), cylinder, key), {}), (name,))


def _uncalibrated() -> Iterator[Trial]:
    # to sensors whose slopes are open anyway, position_scale is nothing else
    effects = [name for name in EFFECTS if name != 'position_scale']
    for effect, cylinder in zip(effects, cycle(CYLINDERS), strict=False):
        key, secret = f'uncalibrated/{effect}/{cylinder}/1', of_rig(effect, cylinder, 'medium')
        gains = drawn_gains(zlib.crc32(key.encode()))
        yield _trial(key, secret, (effect,), 'medium', gains=gains)
    for cylinder, repeat in product(CYLINDERS, range(4)):
        key = f'uncalibrated/nothing/{cylinder}/1/{repeat}'
        yield _trial(key, Secret({}, {}, {}), gains=drawn_gains(zlib.crc32(key.encode())))


def wrong(names: tuple[str, ...], cylinder: str, key: str) -> Changes:
    """Return the true values of parameters that the model has wrong."""
    truth = {name: _wrong(name, cylinder, key) for name in names}
    edge, zero = 'exhaust_voltage', 'exhaust_zero_voltage'
    if f'valve.{edge}' in truth:  # a land is displaced as a whole
        valve = settings(cylinder)['valve']
        truth[f'valve.{zero}'] = truth[f'valve.{edge}'] + (valve[zero] - valve[edge])
    return truth


def _wrong(name: str, cylinder: str, key: str) -> Any:
    """Return the true value of a parameter that the model has wrong by 10 to 30 %."""
    section, field = name.split('.')
    model = settings(cylinder)[section][field]
    random = np.random.default_rng([zlib.crc32(key.encode()), zlib.crc32(name.encode())])
    sign = float(random.choice([-1.0, 1.0]))
    if section == 'valve' and field.endswith('voltage'):
        return model + sign * float(random.uniform(0.01, 0.04))  # of an overlap of 0.15 V
    factor = 1.0 + sign * float(random.uniform(0.1, 0.3))
    return [factor * item for item in model] if isinstance(model, list) else factor * model
