"""Eq. 6 and 7: gas springs, mass and energy."""

import numpy as np
import pytest

from pneu_rig_ros.model import chambers
from pneu_rig_ros.model.compiled_model import compiled_model
from pneu_rig_ros.model.parameters import COULOMB_VISCOUS
from pneu_rig_ros.model.plant import Plant, Trajectory

from .rigs import CAPTION_COMMANDS, CYLINDERS, SHUT, changed, drive

FRICTIONLESS = {
    'model': COULOMB_VISCOUS,
    'coulomb_force': 1e-6,
    'breakaway_force': 1e-6,
    'viscous_coefficient': 0.0,
    'micro_viscous_coefficient': 0.0,
    'element_stiffness': (1e2,),
}


@pytest.mark.parametrize('cylinder', CYLINDERS)
def test_sealed_chambers_are_gas_springs_with_the_analytic_frequency(cylinder: str) -> None:
    base = changed(cylinder)
    geometry, gas = base.cylinder, base.gas
    p1 = 4e5
    force = gas.atmospheric_pressure * (geometry.cap_area - geometry.rod_area)
    p2 = (p1 * geometry.cap_area - force) / geometry.rod_area
    operation = {
        'initial_position': geometry.stroke / 2,
        'initial_pressure_1': p1 * (1 + 1e-3),
        'initial_pressure_2': p2,
    }
    model = changed(cylinder, friction=FRICTIONLESS, operation=operation)
    run = drive(Plant(model, tolerance=1e-9), SHUT, 2.0, 1e-4)

    volume_1, volume_2 = chambers.volumes(geometry.stroke / 2, geometry)
    stiffness = gas.heat_capacity_ratio * (
        p1 * geometry.cap_area**2 / volume_1 + p2 * geometry.rod_area**2 / volume_2
    )
    expected = np.sqrt(stiffness / model.total_mass) / (2 * np.pi)
    swing = run.velocity
    up = np.flatnonzero((swing[:-1] < 0) & (swing[1:] >= 0))
    crossing = run.time[up] - swing[up] * 1e-4 / (swing[up + 1] - swing[up])
    measured = (len(crossing) - 1) / (crossing[-1] - crossing[0])
    assert len(crossing) > 10
    assert measured == pytest.approx(expected, rel=1e-3)  # amplitude 0.1 % of the pressure


def outstroke(cylinder: str) -> tuple[Plant, Trajectory]:
    plant = Plant(changed(cylinder), tolerance=1e-8)
    u = CAPTION_COMMANDS[cylinder]
    return plant, drive(plant, (2.5 + u, 2.5 - u), 2.0, 2e-5)


@pytest.mark.parametrize('cylinder', CYLINDERS)
def test_chamber_mass_is_the_integral_of_the_valve_flow(cylinder: str) -> None:
    plant, run = outstroke(cylinder)
    gas = compiled_model(plant.model).gas
    k, enthalpy = gas.heat_capacity_ratio, gas.gas_constant * gas.supply_temperature
    volumes = chambers.volumes(run.position, plant.model.cylinder)
    pressures, masses = (run.pressure_1, run.pressure_2), (run.gas_mass_1, run.gas_mass_2)
    for pressure, volume, mass in zip(pressures, volumes, masses, strict=True):
        # Eq. 6 the other way round: the flow that the pressures must have come from
        middle_p, middle_v = (pressure[1:] + pressure[:-1]) / 2, (volume[1:] + volume[:-1]) / 2
        inflow = middle_v * np.diff(pressure) + k * middle_p * np.diff(volume)
        change = np.sum(inflow) / (k * enthalpy)
        turnover = np.abs(np.diff(mass)).sum()
        assert mass[-1] - mass[0] == pytest.approx(change, abs=1e-5 * turnover)


@pytest.mark.parametrize('cylinder', CYLINDERS)
def test_energy_balance_closes(cylinder: str) -> None:
    plant, run = outstroke(cylinder)
    model = plant.model
    gas, geometry = compiled_model(model).gas, model.cylinder
    k = gas.heat_capacity_ratio
    volume_1, volume_2 = chambers.volumes(run.position, geometry)
    internal = (run.pressure_1 * volume_1 + run.pressure_2 * volume_2) / (k - 1)
    kinetic = 0.5 * model.total_mass * run.velocity**2
    mass = run.gas_mass_1 + run.gas_mass_2
    enthalpy = k / (k - 1) * gas.gas_constant * gas.supply_temperature * (mass - mass[0])
    outside = gas.atmospheric_pressure * (geometry.cap_area - geometry.rod_area)
    work = outside * (run.position - run.position[0])
    power = run.friction_force * run.velocity
    lost = np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(run.time))])
    balance = internal + kinetic - internal[0] - kinetic[0] - enthalpy + work + lost
    assert lost[-1] > 0.01
    assert np.abs(balance).max() < 2e-5 * np.ptp(enthalpy)
