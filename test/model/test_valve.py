"""Eq. 1 and 3-5 against closed forms."""

import math

import numpy as np
import pytest

from pneu_rig_ros.model import valve
from pneu_rig_ros.model.compiled_model import compiled_model
from pneu_rig_ros.model.plant import Plant

from .rigs import changed, drive

MODEL = compiled_model(changed('cylinder_1'))
GAS, VALVE = MODEL.gas, MODEL.valve
K = GAS.heat_capacity_ratio
SUPPLY = 5e5


def printed_coefficient(ratio: float) -> float:
    """Eq. 4 and 5 letter by letter, subsonic branch."""
    root = math.sqrt(ratio ** ((1 - K) / K) - 1)
    return math.sqrt(2 / (K - 1)) * ratio ** ((K + 1) / (2 * K)) * root


def test_command_splits_into_opposite_voltages() -> None:
    assert valve.control_voltages(0.34) == pytest.approx((2.84, 2.16))


@pytest.mark.parametrize('ratio', [0.55, 0.7, 0.9, 0.99, 0.9999])
def test_subsonic_flow_is_equation_4(ratio: float) -> None:
    own = valve.flow_coefficient(ratio, VALVE.laminar_pressure_ratio, GAS)
    assert own == pytest.approx(printed_coefficient(ratio), rel=1e-12)


def test_flow_is_continuous_and_right_at_the_critical_ratio() -> None:
    critical = GAS.critical_ratio
    assert critical == pytest.approx(0.528, abs=5e-4)
    assert GAS.choked_coefficient == pytest.approx(0.58, abs=2e-3)
    assert printed_coefficient(critical) == pytest.approx(GAS.choked_coefficient, rel=1e-12)
    above = valve.flow_coefficient(critical * (1 + 1e-9), 0.9999, GAS)
    below = valve.flow_coefficient(critical * (1 - 1e-9), 0.9999, GAS)
    assert above == pytest.approx(below, rel=1e-9)


def test_flow_falls_to_zero_at_equal_pressures_without_a_jump() -> None:
    laminar = VALVE.laminar_pressure_ratio
    ratios = np.linspace(laminar - 1e-6, 1.0, 2001)
    flow = np.array([valve.flow_coefficient(r, laminar, GAS) for r in ratios])
    assert flow[-1] == 0.0
    assert np.all(np.diff(flow) < 0.0)
    assert np.abs(np.diff(flow)).max() < 2e-4


def flow(voltage: float, zero: float) -> float:
    """Return the mass flow [kg/s] into a chamber, the exhaust's opening counted from ``zero``."""
    counted = VALVE._replace(exhaust_zero_voltage=zero)
    return valve.mass_flow(voltage, 2e5, SUPPLY, counted, GAS)


def sonic_exhaust(opening_voltage: float) -> float:
    """Return the mass flow [kg/s] out of the chamber by hand; 2 bar are choked."""
    opening = VALVE.exhaust_coefficient * opening_voltage
    return GAS.choked_coefficient * 2e5 * GAS.flow_scale * opening


def test_valve_opens_without_a_jump_if_the_exhaust_is_counted_from_its_edge() -> None:
    for edge in (VALVE.intake_voltage, VALVE.exhaust_voltage):
        near = [flow(edge + d, VALVE.exhaust_voltage) for d in (-1e-9, 1e-9)]
        assert np.abs(near).max() < 1e-12
    assert flow(2.5, VALVE.exhaust_voltage) == 0.0


def test_exhaust_jumps_at_its_edge_as_equation_3_is_printed() -> None:
    edge, zero = VALVE.exhaust_voltage, VALVE.intake_voltage
    assert flow(edge, zero) == flow(2.5, zero) == flow(zero, zero) == 0.0
    assert flow(edge - 1e-9, zero) == pytest.approx(-sonic_exhaust(zero - edge), rel=1e-8)


@pytest.mark.parametrize('zero', [VALVE.exhaust_voltage, 2.5, VALVE.intake_voltage])
def test_exhaust_opens_with_the_voltage_below_its_zero(zero: float) -> None:
    for voltage in (0.0, 1.0, 2.2):
        assert flow(voltage, zero) == pytest.approx(-sonic_exhaust(zero - voltage), rel=1e-12)
    assert flow(3.0, zero) == flow(3.0, VALVE.exhaust_voltage) > 0.0


def test_flow_reverses_with_the_pressure_difference() -> None:
    inward = valve.mass_flow(3.0, 4e5, 5e5, VALVE, GAS)
    outward = valve.mass_flow(3.0, 5e5, 4e5, VALVE, GAS)
    assert inward == pytest.approx(-outward)
    assert inward > 0.0
    assert valve.mass_flow(2.0, 0.9e5, SUPPLY, VALVE, GAS) > 0.0  # below atmosphere: sucked in


def test_choked_blow_down_is_exponential() -> None:
    start = 4e5
    operation = {
        'initial_position': 0.3,
        'initial_pressure_1': 5e5,
        'initial_pressure_2': start,
    }
    model = changed('cylinder_1', operation=operation)
    run = drive(Plant(model), (2.5, 2.0), 0.2, 1e-3)
    choked = run.pressure_2 > GAS.atmospheric_pressure / GAS.critical_ratio
    opening = VALVE.exhaust_coefficient * (VALVE.exhaust_zero_voltage - 2.0)
    sonic = GAS.gas_constant * GAS.supply_temperature * GAS.flow_scale
    rate = K * sonic * GAS.choked_coefficient * opening / model.cylinder.rod_dead_volume
    expected = start * np.exp(-rate * run.time)
    assert choked.sum() > 50
    assert np.all(run.position == 0.3)
    np.testing.assert_allclose(run.pressure_2[choked], expected[choked], rtol=1e-5)
