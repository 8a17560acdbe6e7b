"""Eq. 9-16 against closed forms."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pneu_rig_ros.model import friction
from pneu_rig_ros.model import layout as at
from pneu_rig_ros.model.compiled_model import compiled_model
from pneu_rig_ros.model.parameters import (
    FILM_NORMALISED,
    FILM_PRINTED,
    FILM_READINGS,
    FILM_RESTS_BY_SPEED,
    FILM_RESTS_WITH_CLOCK,
    FRICTION_MODELS,
    REVISED_LUGRE_DWELL,
    STATIC_FRICTION_READINGS,
    Friction,
)
from pneu_rig_ros.model.plant import Plant

from .rigs import CYLINDERS, SHUT, changed, drive


def steady_level(speed: float, law: Friction, static: float) -> float:
    """g(v, h_ss) worked out by hand from Eq. 11, 14 and 15."""
    name = FRICTION_MODELS[law.model]
    if name == 'coulomb_viscous':
        return law.coulomb_force
    film = 0.0
    if name.startswith('revised'):
        slope = (1 - law.coulomb_force / static) * law.film_velocity ** (-2 / 3)
        film = slope * min(speed, law.film_velocity) ** (2 / 3)
    stribeck = np.exp(-((speed / law.stribeck_velocity) ** law.stribeck_exponent))
    return law.coulomb_force + ((1 - film) * static - law.coulomb_force) * stribeck


@pytest.mark.parametrize('velocity', [-0.2, -0.01, 0.004, 0.02, 0.3])
@pytest.mark.parametrize('film_reading', range(len(FILM_READINGS)))
@pytest.mark.parametrize('name', FRICTION_MODELS)
def test_constant_velocity_gives_the_stribeck_curve(
    name: str, film_reading: int, velocity: float
) -> None:
    law = {'model': FRICTION_MODELS.index(name), 'film_reading': film_reading}
    plant = Plant(changed('cylinder_1', friction=law))
    model, point = compiled_model(plant.model), plant.initial_integrator_state().end
    point.memory[at.STICKING], point.memory[at.HELD_STATIC] = 0.0, 13.0
    point.state[at.VELOCITY] = velocity

    def seal(t: float, seal_state: list[float]) -> list[float]:
        point.state[[at.DEFLECTION, at.FILM]] = seal_state
        plant.right_hand_side(t, point, model)
        return [point.rate[at.DEFLECTION], point.rate[at.FILM]]

    end = solve_ivp(seal, (0, 20), [0, 0], method='LSODA', rtol=1e-9, atol=1e-13)
    deflection = end.y[0, -1]
    law_used = model.friction
    static = 13.0 if law_used.model == REVISED_LUGRE_DWELL else law_used.breakaway_force
    force = friction.friction_force(
        sum(plant.model.friction.element_stiffness) * deflection, 0.0, velocity, 0.0, law_used
    )
    speed = abs(velocity)
    expected = steady_level(speed, law_used, static) + law_used.viscous_coefficient * speed
    assert force == pytest.approx(np.copysign(expected, velocity), rel=1e-5)


def test_static_friction_grows_as_equation_16() -> None:
    law = compiled_model(changed('cylinder_1')).friction
    grown = [
        friction.static_friction(t, law.breakaway_force, law.coulomb_force, law)
        for t in (0.0, 1.0, 10.0, 100.0, 1e9)
    ]
    assert grown == pytest.approx([4.0, 6.3, 9.3, 13.5, 15.45], abs=0.06)


def test_film_reaches_the_ratio_of_equation_15_at_the_film_velocity() -> None:
    law = compiled_model(changed('cylinder_1')).friction._replace(film_reading=FILM_PRINTED)
    steady = friction.film_steady_state(law.film_velocity, 15.45, 4.0, law)
    assert steady == pytest.approx(1 - 4.0 / 15.45)
    assert friction.film_steady_state(1.0, 15.45, 4.0, law) == steady
    eighth = friction.film_steady_state(law.film_velocity / 8, 15.45, 4.0, law)
    assert eighth == pytest.approx(steady / 4)


def test_both_film_readings_agree_for_constant_static_friction() -> None:
    law = compiled_model(changed('cylinder_2')).friction
    for share in (0.0, 0.3, 1.0):
        film = share * (1 - law.coulomb_force / 20.0)
        printed = law._replace(film_reading=FILM_PRINTED)
        normalised = law._replace(film_reading=FILM_NORMALISED)
        levels = [
            friction.static_level(film, 20.0, law.coulomb_force, printed),
            friction.static_level(share, 20.0, law.coulomb_force, normalised),
        ]
        assert levels[0] == pytest.approx(levels[1])


@pytest.mark.parametrize(
    ('sticking', 'film', 'steady', 'time'),
    [
        (True, 0.1, 0.5, 36.0),
        (False, 0.1, 0.5, 0.01),
        (False, 0.5, 0.1, 0.32),
    ],
)
def test_film_time_constants_are_those_of_equation_13(
    sticking: bool, film: float, steady: float, time: float
) -> None:
    law = compiled_model(changed('cylinder_1')).friction
    assert friction.film_rate(film, steady, sticking, law) == pytest.approx((steady - film) / time)


@pytest.mark.parametrize(
    ('reading', 'velocity', 'sticking', 'rests'),
    [
        (FILM_RESTS_WITH_CLOCK, 1.0, True, True),
        (FILM_RESTS_WITH_CLOCK, 0.0, False, False),
        (FILM_RESTS_BY_SPEED, -2e-3, True, False),
        (FILM_RESTS_BY_SPEED, -5e-4, False, True),
    ],
)
def test_film_rests_with_the_clock_or_by_speed(
    reading: int, velocity: float, sticking: bool, rests: bool
) -> None:
    law = compiled_model(changed('cylinder_1')).friction
    law = law._replace(film_rest_reading=reading, film_rest_velocity=1e-3)
    assert friction.film_rests(velocity, sticking, law) == rests


@pytest.mark.parametrize('name', FRICTION_MODELS)
@pytest.mark.parametrize('cylinder', CYLINDERS)
def test_stuck_piston_does_not_drift(cylinder: str, name: str) -> None:
    law = {'model': FRICTION_MODELS.index(name)}
    plant = Plant(changed(cylinder, friction=law, operation={'initial_position': 0.1}))
    constants = plant.model.friction
    level = constants.coulomb_force if name == 'coulomb_viscous' else constants.breakaway_force
    while plant.state.friction_force < 0.8 * level:  # load it slowly, then shut the valves
        drive(plant, (2.66, 2.5), 0.01)
    run = drive(plant, SHUT, 65.0)
    settled = run.time - run.time[0] >= 5.0
    assert 0.75 * level < run.friction_force[-1] < 0.9 * level
    assert np.ptp(run.position[settled]) < 1e-6


@pytest.mark.parametrize('reading', STATIC_FRICTION_READINGS)
def test_readings_of_equation_16_differ_only_after_the_first_breakaway(reading: str) -> None:
    index = STATIC_FRICTION_READINGS.index(reading)
    law = {'model': REVISED_LUGRE_DWELL, 'static_friction_reading': index}
    run = drive(Plant(changed('cylinder_2', friction=law)), (2.84, 2.16), 3.0)
    reference = drive(Plant(changed('cylinder_2')), (2.84, 2.16), 3.0)
    first = int(np.argmin(run.sticking))
    assert first > 100
    before = slice(0, first - 1)
    # held readings do not see the growth during the first rest, a share of 1e-4 of F_s
    np.testing.assert_allclose(run.position[before], reference.position[before], atol=1e-7)


@pytest.mark.parametrize('pause', [0.5, 2.0, 8.0, 30.0])
@pytest.mark.parametrize('cylinder', CYLINDERS)
def test_breakaway_after_a_pause_needs_the_force_of_equation_16(
    cylinder: str, pause: float
) -> None:
    # thresholds between the creep while sticking and the speed of the slips; no film
    law = {
        'stop_velocity': 1e-3,
        'start_velocity': 2e-3,
        'element_stiffness': (2e5,),
        'film_time_acceleration': 1e4,
        'film_time_dwell': 1e6,
    }
    operation = {'initial_position': 0.05}
    plant = Plant(changed(cylinder, friction=law, operation=operation), tolerance=1e-8)
    while plant.state.sticking or plant.state.position < 0.06:
        drive(plant, (2.8, 2.2), 0.01)
    while not plant.state.sticking:
        drive(plant, SHUT, 0.01)
    drive(plant, SHUT, pause)
    run = drive(plant, (2.85, 2.15), 4.0)
    constants = compiled_model(plant.model).friction
    end = int(np.argmin(run.sticking))
    assert end > 10
    dwell = run.dwell_time[end - 1]
    assert dwell > pause
    static = friction.static_friction(
        dwell, constants.breakaway_force, constants.coulomb_force, constants
    )
    level = friction.static_level(run.film[end], static, constants.coulomb_force, constants)
    # the bristle approaches the level while it creeps, so the peak stays a little below
    peak = run.friction_force[: end + 1].max()
    viscous = constants.viscous_coefficient * constants.start_velocity
    assert 0.92 * level < peak < 1.01 * level + viscous
