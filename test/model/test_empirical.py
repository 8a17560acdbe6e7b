"""Empirical terms: what the plant adds is what the table says, and guards hold."""

from typing import Any, cast

import numpy as np
import pytest

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model import effects
from pneu_rig_ros.model.compiled_model import Signals
from pneu_rig_ros.model.empirical import OUTPUTS, TERMS
from pneu_rig_ros.model.empirical_effects import EFFECTS
from pneu_rig_ros.model.plant import Plant
from pneu_rig_ros.rig.configuration import configuration_from_yaml
from pneu_rig_ros.rig.yaml_file import configuration_folder

from .rigs import SHUT, changed, drive
from .test_effect_physics import COMPILED, GAS, STROKE, at_rest, contribute, plant_with, settle

CYLINDER = (configuration_folder() / 'cylinder_2.yaml').read_text()
EVERY = [(output, name) for output in OUTPUTS for name in OUTPUTS[output].terms]
STATES = [
    at_rest(),
    at_rest(
        time=0.01,
        position=0.02,
        velocity=0.03,
        bristle_force=3.0,
        voltage_1=3.1,
        voltage_2=1.9,
        gas_mass_2=2e-4,
        pressure_1=4e5,
        dwell_time=20.0,
    ),
    at_rest(
        time=0.03,
        position=0.15,
        velocity=-2e-4,
        bristle_force=-2.0,
        voltage_1=2.2,
        voltage_2=2.6,
        gas_mass_1=3e-4,
        pressure_2=3e5,
        dwell_time=0.3,
    ),
]


def described(output: str, name: str, value: float) -> dict[str, Any]:
    """Return the effect that adds so many times a term to an output."""
    effect, parameter = OUTPUTS[output].effect, OUTPUTS[output].parameter.format(name)
    return {effect: EFFECTS[effect].null._replace(**{parameter: value})}


def own(output: str, name: str, value: float) -> tuple[str, Any]:
    """Return the effect that adds a term to an output, and its parameters."""
    ((effect, parameters),) = described(output, name, value).items()
    return effect, parameters


def added(output: str, name: str, signals: Signals) -> float:
    """Return what the plant adds to an output where the coefficient of one term is 1e-3."""
    effect, parameters = own(output, name, 1e-3)
    fields = {key: value for group in signals[1:] for key, value in group._asdict().items()}
    first, second, _ = contribute(effect, parameters, time=signals.time, **fields)
    if output == 'static_friction':
        return cast(float, second - first)
    return cast(float, second if output.endswith('_2') else first)


@pytest.mark.parametrize(('output', 'name'), [e for e in EVERY if not TERMS[e[1]].integrated])
def test_plant_adds_what_the_table_says(output: str, name: str) -> None:
    column = np.array([TERMS[name].signal(s, COMPILED) for s in STATES])
    assert [added(output, name, s) for s in STATES] == pytest.approx(1e-3 * column, rel=1e-12)
    assert column.any()


def test_travel_is_the_integral_of_the_speed() -> None:
    effect, parameters = own('friction', 'travel', 2.0)
    signals = {'velocity': -0.1 * STROKE}
    after = settle(effect, parameters, 5.0, **signals)
    assert contribute(effect, parameters, after, **signals)[:2] == pytest.approx((1.0, 1.0))


def test_sums_are_those_of_their_terms_in_a_plant_too() -> None:
    """Coefficients reach the compiled plant in the order of the table."""
    chosen = effects.nulls()
    chosen |= described('pressure_2', 'gauge_2', 3.0)
    chosen |= described('position', 'position_squared', 1e-3)
    run = drive(Plant(changed('cylinder_2'), chosen), (3.0, 2.0), 0.5)
    gauge = (run.pressure_2 - GAS.atmospheric_pressure) / 5e5
    assert run.pressure_2_reading - run.pressure_2 == pytest.approx(3.0 * gauge, abs=1e-9)
    share = run.position / STROKE
    assert run.position_reading - run.position == pytest.approx(1e-3 * share**2, abs=1e-15)
    speed = 2e-3 * share / STROKE * run.velocity
    assert run.velocity_reading - run.velocity == pytest.approx(speed, abs=1e-12)


@pytest.mark.parametrize('name', EFFECTS)
def test_null_parameters_vanish_with_the_memory(name: str) -> None:
    effect = EFFECTS[name]
    rate = np.full(len(effect.states), np.nan)
    pair = effect.contribution(STATES[1], COMPILED, effect.null, np.ones(len(rate)), rate)
    assert pair == (0.0, 0.0)
    assert not rate.any()


def test_flow_out_of_a_chamber_without_gas_ends() -> None:
    effect, parameters = own('flow_1', 'constant', -1e-4)
    nearly_empty = {'pressure_1': 0.1 * GAS.atmospheric_pressure}
    assert contribute(effect, parameters, **nearly_empty)[0] == pytest.approx(-1e-5)
    assert contribute(effect, parameters)[0] == -1e-4
    plant = plant_with(effect, *parameters)
    run = drive(plant, SHUT, 20.0)
    assert 0.0 < run.pressure_1[-1] < 0.01 * run.pressure_1[0]


def test_flow_is_gas_at_supply_temperature() -> None:
    """The gas has what flowed in, and its energy the enthalpy of it: Eq. 6."""
    effect, parameters = own('flow_1', 'constant', 1e-5)
    plant = plant_with(effect, *parameters, operation={'initial_position': 0.1})
    run = drive(plant, SHUT, 0.2)
    flowed = 1e-5 * (run.time[-1] - run.time[0])
    assert run.gas_mass_1[-1] - run.gas_mass_1[0] == pytest.approx(flowed, rel=1e-6)
    enthalpy = GAS.heat_capacity_ratio * GAS.gas_constant * GAS.supply_temperature
    cylinder, power = plant.model.cylinder, GAS.heat_capacity_ratio - 1.0
    volume = run.position * cylinder.cap_area + cylinder.cap_dead_volume
    # d(p V^k)/dt = k R T_s V^(k-1) m', whatever the piston does
    stored = run.pressure_1[-1] * volume[-1] ** (power + 1.0) - run.pressure_1[0] * volume[0] ** (
        power + 1.0
    )
    assert stored / np.mean(volume**power) == pytest.approx(enthalpy * flowed, rel=1e-4)


def test_friction_that_is_taken_away_never_drives() -> None:
    effect, parameters = own('friction', 'constant', -1e3)
    run = drive(plant_with(effect, *parameters), (2.7, 2.3), 1.0)
    assert run.position[-1] > 1e-3
    assert (run.friction_force * run.velocity).min() > -1e-2


def test_a_rig_file_names_the_terms_that_act_alone() -> None:
    text = 'effects: {empirical_flow: {gauge_1_1: -1e-5 kg/s}}'
    rig = configuration_from_yaml(f'{CYLINDER}\n{text}', 'rig')
    assert rig.effects == described('flow_1', 'gauge_1', -1e-5)
    assert configuration_from_yaml(rig.to_yaml(), 'rig') == rig
    assert 'gauge_2_1' not in rig.to_yaml()
    wrong = text.replace('gauge_1_1', 'gage_1_1')
    with pytest.raises(RigError, match="did you mean 'gauge_1_1'"):
        configuration_from_yaml(f'{CYLINDER}\n{wrong}', 'rig')
