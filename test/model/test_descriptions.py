"""What describes a gap without a name, against closed forms."""

import math

import pytest

from pneu_rig_ros.model import effects

from .rigs import SHUT, drive
from .test_effect_physics import AT_REST, GAS, STROKE, contribute, plant_with, settle


def terms(name: str, **values: float) -> tuple[float, ...]:
    """Return the coefficients of a description, all others zero."""
    return tuple(effects.load(name).null._replace(**values))


def test_change_of_a_voltage_is_forgotten() -> None:
    name, signals = 'described_voltage', {'voltage_1': 3.0, 'voltage_2': 2.3}
    change = terms(name, change=-0.5)
    assert contribute(name, change, **signals)[:2] == pytest.approx((-0.25, 0.1))
    after = settle(name, change, 0.02, **signals)
    assert contribute(name, change, after, **signals)[:2] == pytest.approx(
        (-0.25 * math.exp(-1.0), 0.1 * math.exp(-1.0)), rel=1e-6
    )


def test_error_of_a_spool_is_odd_in_its_way() -> None:
    name = 'described_voltage'
    bent = terms(name, voltage=0.1, squared=0.2)
    out, back, rate = contribute(name, bent, voltage_1=3.5, voltage_2=1.5)
    assert (out, back) == pytest.approx((0.3, -0.3))
    assert not rate.any()


def test_cold_gas_is_warmed_to_the_supply_and_warm_gas_cooled() -> None:
    conductance = 0.2
    plant = plant_with('described_heat', *terms('described_heat', cold=conductance))
    plain = plant_with('described_heat', *terms('described_heat'))
    for one in (plant, plain):
        drive(one, (3.0, 2.5), 0.3)
    shut, adiabatic = drive(plant, SHUT, 60.0), drive(plain, SHUT, 60.0)
    # all heat gone, the gas has the temperature of the supply: p V = m R T
    for run, same in ((shut, True), (adiabatic, False)):
        volume = run.position[-1] * plant.model.cylinder.cap_area
        volume += plant.model.cylinder.cap_dead_volume
        gas = run.gas_mass_1[-1] * GAS.gas_constant * GAS.supply_temperature
        assert (run.pressure_1[-1] * volume == pytest.approx(gas, rel=1e-3)) == same


def test_heat_out_of_a_gas_without_warmth_ends() -> None:
    name, signals = 'described_heat', {'pressure_1': 1e3}
    warmth = 1e3 * AT_REST.volume_1 / (AT_REST.gas_mass_1 * GAS.gas_constant)
    heat = contribute(name, terms(name, constant=-2.0), **signals)
    share = warmth / GAS.supply_temperature
    assert heat[:1] == pytest.approx((-2.0 * share,))
    assert contribute(name, terms(name, constant=2.0), **signals)[0] == 2.0


def test_force_of_the_ends_is_felt_there_alone() -> None:
    name = 'described_force'
    values = terms(name, ends=-5.0, ends_velocity=-4.0)
    for share, expected in ((0.0, 5.0), (0.5, 0.0), (1.0, -5.0)):
        force = contribute(name, values, position=share * STROKE)[0]
        assert force == pytest.approx(expected)
    braked = contribute(name, values, position=STROKE, velocity=0.05)[0]
    assert braked == pytest.approx(-5.0 - 4.0 * 0.5)


def test_level_at_rest_grows_with_the_logarithm_of_the_dwell() -> None:
    name = 'described_friction'
    coulomb, static, _ = contribute(name, terms(name, static_dwell=2.0), dwell_time=math.e - 1.0)
    assert (coulomb, static) == pytest.approx((0.0, 2.0))
