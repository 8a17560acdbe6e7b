"""The shortest time in which the states of an effect change."""

import math

import pytest

from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.effect import LEAST_TIME
from pneu_rig_ros.rig import load_configuration


def shortest(name: str, **changes: float) -> float:
    effect = library.load(name)
    operation = load_configuration('cylinder_1').model.operation._replace(load_mass=2.0)
    model = load_configuration('cylinder_1').model._replace(operation=operation)
    return effect.shortest_time(effect.probes[0]._replace(**changes), model)


@pytest.mark.parametrize('time', [0.0, 1e-4, 3e-3, 0.2])
def test_it_is_the_time_constant_but_not_less_than_is_integrated(time: float) -> None:
    assert shortest('valve_lag', time_constant=time) == max(time, LEAST_TIME)


def test_it_is_the_least_of_several() -> None:
    assert shortest('film_dynamics', time_acceleration=0.3, time_deceleration=0.02) == 0.02


def test_it_is_the_least_that_is_integrated_where_nothing_says_it() -> None:
    assert shortest('spool_hysteresis') == LEAST_TIME


def test_a_load_swings_with_its_natural_frequency() -> None:
    assert shortest('load_compliance', compliance=5e-5, damping=0.0) == pytest.approx(0.01)
    assert shortest('load_compliance', compliance=5e-5, damping=400.0) == pytest.approx(0.005)


def test_a_travel_answers_to_nothing() -> None:
    assert shortest('travel_dependent_friction') == math.inf
