"""The rungs of the friction ladder: a lower law with the missing effect is the higher law."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

from pneu_rig_ros.model import effects
from pneu_rig_ros.model.parameters import (
    FADES_WHILE_SLIDING,
    FILM_RESTS_BY_SPEED,
    STATIC_FRICTION_READINGS,
    Friction,
)
from pneu_rig_ros.model.plant import Plant, Trajectory

from .rigs import CYLINDERS, INTERVAL, changed, worst

COMMANDS = dict(zip(CYLINDERS, (0.32, 0.36, 0.4), strict=True))
TOLERANCE = 1e-8
AGREE = 1e-5
"""Largest difference of two runs that are the same but for rounding and steps [full scale]."""

COULOMB_VISCOUS, LUGRE, REVISED, DWELL = range(4)
Effects = dict[str, Any]


class Rung(NamedTuple):
    """Changes of the higher and of the lower law, and the effects between them."""

    higher: Callable[[Friction], dict[str, Any]]
    lower: Callable[[Friction], dict[str, Any]]
    missing: Callable[[Friction], Effects]


HALVED = 2.0
"""F_smax - F_c over that of a law whose constant static friction has half of it [-]."""


def some_constant_static_friction(law: Friction) -> float:
    return 0.5 * (law.breakaway_force + law.coulomb_force)


def dwell(law: Friction, excess_ratio: float = 1.0) -> Effects:
    values = 1.0, law.dwell_coefficient, law.dwell_exponent, excess_ratio
    return {'dwell_static_friction': effects.load('dwell_static_friction').parameters(*values)}


def stribeck(law: Friction) -> Effects:
    excess = law.breakaway_force - law.coulomb_force
    values = excess, law.stribeck_velocity, law.stribeck_exponent
    return {'stribeck': effects.load('stribeck').parameters(*values)}


def film(law: Friction) -> Effects:
    times = law.film_time_acceleration, law.film_time_deceleration, law.film_time_dwell
    parameters = effects.load('film_dynamics').parameters
    return {'film_dynamics': parameters(1.0 / law.film_velocity, *times)}


def fluid(law: Friction) -> Effects:
    return {'fluid_inertia': effects.load('fluid_inertia').parameters(0.02)}


def hysteresis(law: Friction) -> Effects:
    stiffness, limit = 0.5 * law.element_stiffness[0], 0.2 * law.breakaway_force
    parameters = effects.load('presliding_hysteresis').parameters
    return {'presliding_hysteresis': parameters(stiffness, limit)}


def two_elements(law: Friction) -> dict[str, Any]:
    half = 0.5 * law.element_stiffness[0]
    return {'element_stiffness': (half, half), 'element_limit': (0.2 * law.breakaway_force,)}


RUNGS = {
    'dwell_static_friction': Rung(
        lambda _: {'model': DWELL},
        lambda law: {'model': REVISED, 'breakaway_force': some_constant_static_friction(law)},
        lambda law: dwell(law, HALVED),
    ),
    'stribeck': Rung(lambda _: {'model': LUGRE}, lambda _: {'model': COULOMB_VISCOUS}, stribeck),
    'film_dynamics': Rung(lambda _: {'model': REVISED}, lambda _: {'model': LUGRE}, film),
    'film and dwell': Rung(
        lambda _: {'model': DWELL},
        lambda law: {'model': LUGRE, 'breakaway_force': some_constant_static_friction(law)},
        lambda law: film(law) | dwell(law, HALVED),
    ),
    'fluid_inertia': Rung(
        lambda _: {'model': REVISED, 'fluid_time_constant': 0.02},
        lambda _: {'model': REVISED},
        fluid,
    ),
}


@pytest.mark.parametrize('reading', range(len(STATIC_FRICTION_READINGS)))
def test_dwell_and_film_keep_to_the_readings_of_the_law(reading: int) -> None:
    keys = {'static_friction_reading': reading, 'film_rest_reading': FILM_RESTS_BY_SPEED}
    rung = Rung(
        lambda _: {'model': DWELL, **keys},
        lambda law: {
            'model': LUGRE,
            'breakaway_force': some_constant_static_friction(law),
            **keys,
        },
        lambda law: film(law) | dwell(law, HALVED),
    )
    wanted, found, without = runs(rung, 'cylinder_1')
    assert worst(wanted.position, found.position, 0.3) < AGREE
    assert worst(wanted.position, without.position, 0.3) > 100.0 * AGREE


@pytest.mark.parametrize('cylinder', CYLINDERS)
def test_static_friction_fades_by_the_equation_of_the_effect_not_of_the_law(cylinder: str) -> None:
    fades = {'static_friction_reading': FADES_WHILE_SLIDING, 'memory_time': 0.3}
    other = {'dwell_coefficient': 2.0, 'dwell_exponent': 1.0}
    rung = Rung(
        lambda _: {'model': DWELL, **fades}, lambda _: {'model': REVISED, **fades, **other}, dwell
    )
    wanted, found, without = runs(rung, cylinder)
    stroke = changed(cylinder).cylinder.stroke
    assert worst(wanted.position, found.position, stroke) < AGREE
    assert worst(wanted.position, without.position, stroke) > 100.0 * AGREE


@pytest.mark.parametrize('cylinder', CYLINDERS)
def test_static_friction_grows_between_the_levels_that_other_effects_leave(cylinder: str) -> None:
    follows = {'static_friction_reading': STATIC_FRICTION_READINGS.index('follows_clock')}
    rung = Rung(
        lambda _: {'model': DWELL, **follows}, lambda _: {'model': REVISED, **follows}, dwell
    )
    sloping = effects.load('position_dependent_friction').parameters(0.6)
    beside = {'position_dependent_friction': sloping}
    wanted, found, without = runs(rung, cylinder, beside=beside)
    bare = runs(rung, cylinder)[0]
    stroke = changed(cylinder).cylinder.stroke
    assert worst(wanted.position, found.position, stroke) < AGREE
    assert worst(wanted.position, without.position, stroke) > 100.0 * AGREE
    assert worst(wanted.position, bare.position, stroke) > 100.0 * AGREE


@pytest.mark.parametrize('cylinder', CYLINDERS)
@pytest.mark.parametrize('name', RUNGS)
def test_lower_law_with_the_effect_is_the_higher_law(name: str, cylinder: str) -> None:
    wanted, found, without = runs(RUNGS[name], cylinder)
    stroke = changed(cylinder).cylinder.stroke
    assert worst(wanted.position, found.position, stroke) < AGREE
    assert worst(wanted.pressure_1, found.pressure_1, 5e5) < AGREE
    assert worst(wanted.velocity, found.velocity, 1.0) < 30.0 * AGREE
    assert worst(wanted.position, without.position, stroke) > 100.0 * AGREE


@pytest.mark.parametrize('cylinder', CYLINDERS)
def test_hysteresis_is_a_maxwell_slip_element_dragged_within_a_sample(cylinder: str) -> None:
    rung = Rung(
        two_elements,
        lambda law: {'element_stiffness': (0.5 * law.element_stiffness[0],)},
        hysteresis,
    )
    wanted, found, without = runs(rung, cylinder, duration=4.0)
    full = changed(cylinder).friction.breakaway_force
    error = np.abs(wanted.friction_force - found.friction_force)
    gap = np.abs(wanted.friction_force - without.friction_force)
    assert np.mean(error) < 0.002 * full
    assert np.mean(error) < 0.1 * np.mean(gap)


def runs(
    rung: Rung, cylinder: str, duration: float = 8.0, beside: Effects | None = None
) -> tuple[Trajectory, Trajectory, Trajectory]:
    """
    Return out-and-in runs with the higher law, with the lower and the effect, without it.

    :param beside: effects that all three have
    """
    law = changed(cylinder).friction
    higher = changed(cylinder, friction=rung.higher(law))
    lower = changed(cylinder, friction=rung.lower(law))
    null = effects.nulls() | (beside or {})
    plants = (
        Plant(higher, null, TOLERANCE),
        Plant(lower, null | rung.missing(law), TOLERANCE),
        Plant(lower, null, TOLERANCE),
    )
    count, u = round(duration / INTERVAL), COMMANDS[cylinder]
    out = (np.arange(count) < 0.6 * count)[:, np.newaxis]
    voltages = np.where(out, (2.5 + u, 2.5 - u), (2.5 - u, 2.5 + u))
    one, two, three = (plant.run(voltages, INTERVAL) for plant in plants)
    return one, two, three
