"""Resistance of lines and limited speed of spools against their equations and limiting cases."""

import math

import numpy as np
import pytest

from pneu_rig_ros.model import valve

from .test_effect_physics import GAS, SUPPLY, VALVE, contribute, settle


def passed(voltage: float, pressure: float, resistance: float) -> float:
    """Return the flow into chamber 1 through valve and line [kg/s]."""
    signals = {'voltage_1': voltage, 'pressure_1': pressure}
    without = valve.mass_flow(voltage, pressure, SUPPLY, VALVE, GAS)
    return float(without + contribute('line_resistance', (resistance,), **signals)[0])


@pytest.mark.parametrize('pressure', [1.1e5, 3e5, 4.9e5, 6e5])
@pytest.mark.parametrize('voltage', [0.0, 2.0, 3.0, 5.0])
@pytest.mark.parametrize('resistance', [1e7, 3e8, 1e10])
def test_flow_of_valve_and_line_is_the_same(
    voltage: float, pressure: float, resistance: float
) -> None:
    flow = passed(voltage, pressure, resistance)
    between = pressure**2 + resistance**2 * flow * abs(flow)
    assert between > 0.0
    through_valve = valve.mass_flow(voltage, math.sqrt(between), SUPPLY, VALVE, GAS)
    assert flow == pytest.approx(through_valve, rel=1e-5)
    assert flow != 0.0


def test_line_alone_limits_the_flow_of_a_valve_that_is_wide_open() -> None:
    filling, emptying = passed(5.0, 1.5e5, 1e10), passed(0.0, 4e5, 1e10)
    atmosphere = GAS.atmospheric_pressure
    # the valve, in series, takes the few percent that the opening adds to an infinite one
    assert 0.95 < filling / (math.sqrt(SUPPLY**2 - 1.5e5**2) / 1e10) < 1.0
    assert 0.95 < emptying / (-math.sqrt(4e5**2 - atmosphere**2) / 1e10) < 1.0


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
