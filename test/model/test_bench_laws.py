"""Laws that real benches showed, each against a closed form."""

import math
from typing import Any

import numpy as np
import pytest

from pneu_rig_ros.model.chambers import pressure_rate, wall_area
from pneu_rig_ros.model.valve import mass_flow

from .rigs import SHUT, drive, plant_with
from .test_effect_physics import (
    AT_REST,
    COMPILED,
    GAS,
    LAW,
    MODEL,
    STROKE,
    SUPPLY,
    VALVE,
    contribute,
    settle,
)

HELD: dict[str, Any] = {
    'breakaway_force': 1e4,
    'coulomb_force': 1e4,
    'element_stiffness': (1e8,),
}
"""Of a piston that no pressure moves [N]."""
ATMOSPHERE = GAS.atmospheric_pressure


@pytest.mark.parametrize('exponent', [0.5, 1.0, 1.2, 2.0])
def test_sealed_volume_empties_as_its_power_says(exponent: float) -> None:
    """g' = -a g^n of the gauge pressure g in bar has a closed form."""
    flow, filled = 2e-5, 4.0
    pressure = ATMOSPHERE + 1e5 * filled
    start = {'initial_pressure_1': pressure, 'initial_position': 0.1}
    plant = plant_with('porous_leak', flow, 0.0, exponent, friction=HELD, operation=start)
    before = plant.state
    run = drive(plant, SHUT, 5.0, 0.01)
    cylinder = MODEL.cylinder
    volume = cylinder.cap_dead_volume + 0.1 * cylinder.cap_area
    energy = GAS.heat_capacity_ratio * GAS.gas_constant * GAS.supply_temperature
    rate = energy * flow / volume / 1e5
    if exponent == 1.0:
        expected = filled * np.exp(-rate * run.time)
    else:
        power = 1.0 - exponent
        expected = np.maximum(filled**power - power * rate * run.time, 0.0) ** (1.0 / power)
    assert 0.01 < expected[-1] < 0.9 * filled
    np.testing.assert_allclose((run.pressure_1 - ATMOSPHERE) / 1e5, expected, rtol=5e-4)
    # what the gas has lost went through the pores at the enthalpy of the supply
    lost = (before.pressure_1 - run.pressure_1[-1]) * volume / energy
    assert before.gas_mass_1 - run.gas_mass_1[-1] == pytest.approx(lost, rel=1e-3)


def test_porous_leak_turns_round_below_atmosphere_and_has_no_jump() -> None:
    def into(gauge: float) -> float:
        values = contribute('porous_leak', (1e-6, 0.0, 0.5), pressure_1=ATMOSPHERE + gauge)
        return float(values[0])

    assert into(1e5) == pytest.approx(-1e-6)
    assert into(-2e4) == pytest.approx(-into(2e4)) == pytest.approx(1e-6 * math.sqrt(0.2))
    assert into(100.0 - 1e-6) == pytest.approx(into(100.0 + 1e-6), rel=1e-6)
    assert into(50.0) == pytest.approx(0.5 * into(100.0))


@pytest.mark.parametrize('exponent', [0.25, 1.0 / 3.0])
@pytest.mark.parametrize('warmer', [30.0, -20.0])
def test_gas_in_a_closed_volume_takes_the_temperature_of_the_wall(
    exponent: float, warmer: float
) -> None:
    """The balance of energy, m c_v d' = -G (|d| / 10 K)^n d, has a closed form."""
    conductance, wall = 0.05, GAS.supply_temperature
    start = {'initial_pressure_1': 4e5, 'initial_position': 0.1}
    plant = plant_with(
        *('natural_convection', conductance, 0.0, exponent),
        temperatures=(wall + warmer, wall),
        friction=HELD,
        operation=start,
    )
    mass = plant.state.gas_mass_1
    run = drive(plant, SHUT, 10.0, 0.01)
    capacity = mass * GAS.gas_constant / (GAS.heat_capacity_ratio - 1.0)
    growth = exponent * (abs(warmer) / 10.0) ** exponent * conductance / capacity
    expected = warmer * (1.0 + growth * run.time) ** (-1.0 / exponent)
    temperature = (wall + warmer) * run.pressure_1 / 4e5  # its volume and mass are constant
    assert abs(expected[-1]) < 0.6 * abs(warmer)
    np.testing.assert_allclose(temperature - wall, expected, atol=0.05)
    assert np.ptp(run.gas_mass_1) == 0.0


def test_heat_by_convection_is_that_of_cooling_at_its_reference() -> None:
    mass = 2e5 * 1e-4 / (GAS.gas_constant * (GAS.supply_temperature + 10.0))
    hot = {'gas_mass_1': mass, 'pressure_1': 2e5, 'volume_1': 1e-4}
    convected = contribute('natural_convection', (0.3, 0.0, 0.3), **hot)
    cooled = contribute('wall_heat_transfer', (0.3, 0.0), **hot)
    assert convected[0] == pytest.approx(cooled[0]) == pytest.approx(-3.0)


@pytest.mark.parametrize('exponent', [0.0, 0.5, 0.8])
def test_forced_convection_grows_with_pressure_and_with_the_wall(exponent: float) -> None:
    def heat(pressure: float, volume: float) -> float:
        mass = pressure * volume / (GAS.gas_constant * (GAS.supply_temperature + 10.0))
        hot = {'gas_mass_1': mass, 'pressure_1': pressure, 'volume_1': volume}
        return float(contribute('forced_convection', (20.0, exponent), **hot)[0])

    area = COMPILED.cylinder.cap_area
    diameter, length = math.sqrt(4.0 * area / math.pi), 0.2
    wall = 2.0 * area + math.pi * diameter * length
    assert heat(3e5, area * length) == pytest.approx(-20.0 * wall * 10.0)
    assert heat(6e5, area * length) == pytest.approx(2.0**exponent * heat(3e5, area * length))
    assert heat(3e5, 0.0001 * area * length) == pytest.approx(-20.0 * 2.0 * area * 10.0, rel=1e-2)


def test_gas_takes_on_the_temperature_of_the_wall_at_its_rate() -> None:
    rate, warmer = 0.4, 20.0
    gas = {'gas_mass_1': 1e-3, 'volume_1': 2e-4}
    hot = GAS.supply_temperature + warmer
    pressure = gas['gas_mass_1'] * GAS.gas_constant * hot / gas['volume_1']
    heat = contribute('gas_mass_heat_transfer', (rate,), pressure_1=pressure, **gas)[0]
    rise = pressure_rate(pressure, gas['volume_1'], 0.0, 0.0, heat, COMPILED.gas)
    at_wall = pressure * GAS.supply_temperature / hot
    assert rise == pytest.approx(rate * (at_wall - pressure))


def test_jets_stir_the_gas_which_then_calms_down() -> None:
    coefficient, decay, volume, pressure = 50.0, 0.4, 2e-4, 2e5
    mass = pressure * volume / (GAS.gas_constant * (GAS.supply_temperature + 10.0))
    gas = {'gas_mass_1': mass, 'pressure_1': pressure, 'volume_1': volume}
    inward = {'voltage_1': 3.0, 'voltage_2': 2.0, **gas}
    flow = mass_flow(3.0, pressure, SUPPLY, VALVE, COMPILED.gas)
    stirred = settle('jet_convection', (coefficient, decay), 20.0 * decay, **inward)
    assert stirred == pytest.approx([flow / 1e-4, 0.0], abs=1e-6)
    heat, other, _ = contribute('jet_convection', (coefficient, decay), stirred, **inward)
    wall = wall_area(volume, COMPILED.cylinder.cap_area)
    assert heat == pytest.approx(-coefficient * (flow / 1e-4) ** 0.67 * wall * 10.0)
    assert other == 0.0
    calm = settle('jet_convection', (coefficient, decay), decay, stirred, **gas)
    assert calm == pytest.approx(stirred / math.e, abs=1e-6)
    assert contribute('jet_convection', (coefficient, decay), calm, **gas)[0] == pytest.approx(
        math.exp(-0.67) * heat
    )


def test_friction_grows_with_a_power_of_each_pressure() -> None:
    def added(bar_1: float, bar_2: float, exponent: float) -> float:
        pressures = (ATMOSPHERE + 1e5 * bar for bar in (bar_1, bar_2))
        both = dict(zip(('pressure_1', 'pressure_2'), pressures, strict=True))
        coulomb, static, _ = contribute('pressure_power_friction', (2.0, exponent), **both)
        assert coulomb == static
        return float(coulomb)

    assert added(1.0, 0.0, 0.6) == pytest.approx(2.0)
    assert added(7.0, 0.0, 0.6) == pytest.approx(2.0 * 7.0**0.6)
    assert added(3.0, 7.0, 0.6) == pytest.approx(added(3.0, 0.0, 0.6) + added(0.0, 7.0, 0.6))
    assert added(-0.5, 0.0, 0.6) == 0.0
    # the power 1 is the linear law
    pressures = {'pressure_1': ATMOSPHERE + 3e5, 'pressure_2': ATMOSPHERE + 1e5}
    linear = contribute('pressure_dependent_friction', (2e-5,), **pressures)[0]
    assert added(3.0, 1.0, 1.0) == pytest.approx(linear)


@pytest.mark.parametrize('rate', [0.5, -0.5])
@pytest.mark.parametrize('velocity', [0.02, -0.02])
def test_friction_drifts_with_the_way_in_either_direction(rate: float, velocity: float) -> None:
    values, side = (rate, 0.4), math.copysign(1.0, rate)
    for duration in (0.5, 40.0, 1e5):
        way = settle('travel_dependent_friction', values, duration, velocity=velocity)
        assert way[0] == pytest.approx(0.02 * duration)
        coulomb, static, _ = contribute('travel_dependent_friction', values, way)
        share = side * 0.4 * (1.0 - math.exp(-0.5 * way[0] / 0.4))
        assert coulomb == pytest.approx(share * LAW.coulomb_force)
        assert static == pytest.approx(share * LAW.breakaway_force)
        if duration == 0.5:  # at first by the rate, whatever the limit
            assert coulomb == pytest.approx(rate * 0.01 * LAW.coulomb_force, rel=0.01)
    assert contribute('travel_dependent_friction', values, velocity=0.0)[2] == 0.0  # at rest


@pytest.mark.parametrize('velocity', [0.0, 0.02])
def test_friction_drifts_with_time_at_rest_as_in_motion(velocity: float) -> None:
    for rate in (0.01, -0.01):
        for time in (1.0, 60.0, 1e6):
            values = contribute(
                'time_dependent_friction', (rate, 0.3), time=time, velocity=velocity
            )
            share = math.copysign(0.3, rate) * (1.0 - math.exp(-0.01 * time / 0.3))
            assert values[0] == pytest.approx(share * LAW.coulomb_force)
            assert values[1] == pytest.approx(share * LAW.breakaway_force)


@pytest.mark.parametrize(
    ('name', 'progress'),
    [('travel_dependent_friction', {'state': (1e3,)}), ('time_dependent_friction', {'time': 1e3})],
)
def test_drift_leaves_some_friction(name: str, progress: dict[str, float]) -> None:
    falls = contribute(name, (-1.0, 2.0), **progress)[0]
    assert falls == pytest.approx(-0.9 * LAW.coulomb_force)


def test_force_of_a_tapered_bore_is_pressure_times_area() -> None:
    area = COMPILED.cylinder.cap_area

    def force(position: float, **signals: float) -> float:
        return float(contribute('bore_taper', (0.02,), position=position, **signals)[0])

    difference = AT_REST.gas.pressure_1 - AT_REST.gas.pressure_2
    assert force(STROKE) == pytest.approx(0.01 * area * difference)
    assert force(0.0) == pytest.approx(-force(STROKE))
    assert force(0.5 * STROKE) == 0.0
    assert force(0.2 * STROKE, velocity=0.1) == force(0.2 * STROKE, velocity=-0.1)
    both = {'pressure_1': 7e5, 'pressure_2': 7e5}
    assert force(STROKE, **both) == 0.0  # the rod's share of the area has no taper


def test_piston_in_a_tapered_bore_rests_where_its_areas_balance() -> None:
    taper = 0.1
    slippery = {'model': 0, 'coulomb_force': 1e-3, 'breakaway_force': 1e-3}
    filled = {'initial_pressure_1': 4e5, 'initial_pressure_2': 2e5, 'initial_position': 0.02}
    plant = plant_with('bore_taper', taper, friction=slippery, operation=filled)
    drive(plant, SHUT, 5.0)
    state, cylinder = plant.state, MODEL.cylinder
    assert abs(state.velocity) < 1e-5
    wider = taper * (state.position / cylinder.stroke - 0.5) * cylinder.cap_area
    gauge_1, gauge_2 = state.pressure_1 - ATMOSPHERE, state.pressure_2 - ATMOSPHERE
    assert abs(wider * (gauge_1 - gauge_2)) > 0.1
    pushed = gauge_1 * (cylinder.cap_area + wider)
    assert pushed == pytest.approx(gauge_2 * (cylinder.rod_area + wider), abs=5e-3)
