"""Tanks, resistance of lines and spools of limited speed against equations and limiting cases."""

import math

import numpy as np
import pytest

from pneu_rig_ros.model import valve

from .test_effect_physics import GAS, SUPPLY, VALVE, contribute, settle


def passed(voltage: float, pressure: float, resistance: float, laminar: float = 0.0) -> float:
    """Return the flow into chamber 1 through valve and line [kg/s]."""
    signals = {'voltage_1': voltage, 'pressure_1': pressure}
    without = valve.mass_flow(voltage, pressure, SUPPLY, VALVE, GAS)
    return float(without + contribute('line_resistance', (resistance, laminar), **signals)[0])


@pytest.mark.parametrize('pressure', [1.1e5, 3e5, 4.9e5, 6e5])
@pytest.mark.parametrize('voltage', [0.0, 2.0, 3.0, 5.0])
@pytest.mark.parametrize(
    ('resistance', 'laminar'),
    [(1e7, 0.0), (3e8, 0.0), (1e10, 0.0), (0.0, 1e12), (0.0, 1e15), (1e8, 1e13)],
)
def test_flow_of_valve_and_line_is_the_same(
    voltage: float, pressure: float, resistance: float, laminar: float
) -> None:
    flow = passed(voltage, pressure, resistance, laminar)
    between = pressure**2 + resistance**2 * flow * abs(flow) + laminar * flow
    assert between > 0.0
    through_valve = valve.mass_flow(voltage, math.sqrt(between), SUPPLY, VALVE, GAS)
    assert flow == pytest.approx(through_valve, rel=1e-5)
    assert flow != 0.0


def test_line_behind_a_choked_valve_takes_nothing() -> None:
    whole = valve.mass_flow(3.0, 1.1e5, SUPPLY, VALVE, GAS)
    resistance = 0.5 * GAS.critical_ratio * SUPPLY / whole  # leaves p_v below the critical ratio
    assert math.hypot(1.1e5, resistance * whole) < GAS.critical_ratio * SUPPLY
    assert passed(3.0, 1.1e5, resistance) == pytest.approx(whole, rel=1e-8)


@pytest.mark.parametrize(('voltage', 'pressure'), [(5.0, 1.5e5), (0.0, 4e5)])
def test_line_alone_limits_the_flow_the_more_it_resists(voltage: float, pressure: float) -> None:
    outside = SUPPLY if voltage > 2.5 else GAS.atmospheric_pressure
    alone = math.sqrt(abs(outside**2 - pressure**2))
    shares = [abs(passed(voltage, pressure, R)) * R / alone for R in (1e8, 1e9, 1e10)]
    assert shares == sorted(shares)
    assert shares[0] < 0.5 * shares[2] < 0.5


def test_laminar_line_passes_the_flow_of_poiseuille() -> None:
    radius, length, viscosity = 0.1e-3, 1.0, 1.8e-5
    heat = GAS.gas_constant * GAS.supply_temperature
    laminar = 16.0 * viscosity * length * heat / (math.pi * radius**4)
    flow = passed(5.0, 2e5, 0.0, laminar)  # the valve is wide open, the tube takes nearly all
    density, drop = 0.5 * (SUPPLY + 2e5) / heat, SUPPLY - 2e5
    assert flow == pytest.approx(
        density * math.pi * radius**4 * drop / (8.0 * viscosity * length), rel=1e-3
    )


def test_lines_of_shut_valves_pass_nothing() -> None:
    assert contribute('line_resistance', (1e9,), voltage_1=2.5, voltage_2=2.5)[:2] == (0.0, 0.0)


def test_spool_of_limited_speed_takes_its_time_for_each_volt() -> None:
    time_per_volt = 0.05
    signals = {'voltage_1': 4.5, 'voltage_2': 1.5}
    for duration in (0.02, 0.04):
        spools = settle('spool_rate_limit', (time_per_volt,), duration, **signals)
        assert spools == pytest.approx([duration / time_per_volt, -duration / time_per_volt])
    arrived = settle('spool_rate_limit', (time_per_volt,), 1.0, **signals)
    assert arrived == pytest.approx([2.0, -1.0], abs=1e-6)
    lack = contribute('spool_rate_limit', (time_per_volt,), np.array([0.5, -1.0]), **signals)
    assert lack[:2] == pytest.approx((-1.5, 0.0))


def test_tank_that_is_drawn_from_for_long_droops_like_a_resistance() -> None:
    fall, recovery, drawing = 4e9, 0.5, {'voltage_1': 3.0, 'voltage_2': 2.0}
    (lack,) = settle('supply_tank', (fall, recovery), 40.0 * recovery, **drawing)
    steady = contribute('supply_tank', (fall, recovery), np.array([lack]), **drawing)
    droop = contribute('supply_droop', (fall * recovery,), **drawing)
    assert steady[:2] == pytest.approx(droop[:2], rel=1e-6)
    assert steady[0] < -0.05 * SUPPLY


def test_tank_loses_what_is_drawn_and_recovers_in_its_time() -> None:
    flow = valve.mass_flow(3.0, 2e5, SUPPLY, VALVE, GAS)  # choked
    (lack,) = settle('supply_tank', (1e7, 1e3), 0.1, voltage_1=3.0)
    assert 1e4 * lack == pytest.approx(1e7 * flow * 0.1, rel=1e-3)
    assert settle('supply_tank', (1e7, 2.0), 2.0, (1.0,)) == pytest.approx([1.0 / math.e])
