"""The modelled rates along a run: against closed forms, and against the simulation they are of."""

import numpy as np
import pytest
from numpy.typing import NDArray

from pneu_rig_ros.model import along
from pneu_rig_ros.model.parameters import Model
from pneu_rig_ros.model.plant import Plant, Trajectory

from .rigs import SHUT, changed, with_effects

Floats = NDArray[np.float64]
FINE = 1e-4
LONG = 0.1
"""A rest that is longer has forgotten how it began [s]."""
PHASES = (((2.9, 2.1), 2.0), (SHUT, 0.5), ((2.0, 3.0), 1.5))
"""Voltages and how long they are held [s]."""


def volumes(model: Model, position: Floats) -> tuple[Floats, Floats]:
    cylinder = model.cylinder
    cap = cylinder.cap_dead_volume + cylinder.cap_area * position
    rod = cylinder.rod_dead_volume + cylinder.rod_area * (cylinder.stroke - position)
    return cap, rod


def enthalpy(model: Model) -> float:
    gas = model.gas
    return gas.heat_capacity_ratio * gas.gas_constant * gas.supply_temperature


def rates_of(plant: Plant, run: Trajectory, voltages: Floats, interval: float) -> Floats:
    """Return the rates along a simulated run, all of whose states are known."""
    measured = np.column_stack([run.position, run.pressure_1, run.pressure_2])
    velocity = 0.5 * (run.velocity[1:] + run.velocity[:-1])
    rests = run.sticking & (np.abs(run.velocity) < along.FASTEST_CREEP)
    contacts = np.where(rests[1:] & rests[:-1], along.RESTS, along.MOVES)
    for side, stop in ((-1, along.AT_INNER_STOP), (1, along.AT_OUTER_STOP)):
        contacts[(run.contact[1:] == side) & (run.contact[:-1] == side)] = stop
    velocity[contacts != along.MOVES] = 0.0
    rates, _ = plant.along(measured, velocity, contacts, voltages, interval)
    return rates


def simulated(model: Model) -> tuple[Trajectory, Floats, Floats]:
    """Return a run, the voltages from its first sample on, and the rates along it."""
    voltages = np.vstack([np.tile(u, (round(time / FINE), 1)) for u, time in PHASES])
    run = Plant(model).run(voltages, FINE)
    return run, voltages[1:], rates_of(Plant(model), run, voltages[1:], FINE)


@pytest.fixture(scope='module')
def model() -> Model:
    return changed('cylinder_1', operation={'initial_position': 0.02, 'rest_time': 60.0})


@pytest.fixture(scope='module')
def case(model: Model) -> tuple[Trajectory, Floats, Floats]:
    return simulated(model)


@pytest.mark.parametrize('chamber', [1, 2])
def test_sources_integrate_to_the_gas_that_is_stored(
    model: Model, case: tuple[Trajectory, Floats, Floats], chamber: int
) -> None:
    run, _, rates = case
    pressure = (run.pressure_1, run.pressure_2)[chamber - 1]
    volume = volumes(model, run.position)[chamber - 1]
    k = model.gas.heat_capacity_ratio
    middle = 0.5 * (pressure[1:] + pressure[:-1])
    stored = np.diff(pressure * volume) + (k - 1.0) * middle * np.diff(volume)
    gained = np.concatenate([[0.0], np.cumsum(stored)]) / enthalpy(model)
    source = np.concatenate([[0.0], np.cumsum(rates[:, along.SOURCE_1 + chamber - 1])]) * FINE
    assert np.ptp(gained) > 2e-5  # [kg]
    assert np.abs(source - gained).max() < 5e-4 * np.ptp(gained)


def test_sealed_adiabatic_chambers_have_no_source(model: Model) -> None:
    time = np.arange(2000) * 1e-3
    position = 0.1 + 0.05 * np.sin(4.0 * time)
    k = model.gas.heat_capacity_ratio
    pressures = [3e5 * (volume[0] / volume) ** k for volume in volumes(model, position)]
    contacts = np.full(time.size - 1, along.MOVES)
    rates, bias = Plant(model).along(
        np.column_stack([position, *pressures]),
        np.diff(position) / 1e-3,
        contacts,
        np.tile(SHUT, (time.size - 1, 1)),
        1e-3,
    )
    assert np.abs(rates[:, :2]).max() < 1e-15  # [kg/s]
    assert not bias.any()


def test_leak_at_constant_volume_is_its_flow(model: Model) -> None:
    """Of a choked leak, m' = C p sqrt(...): in proportion to the pressure."""
    plant = Plant(model, with_effects(chamber_leak=(2e-9, 0.0)))
    levels = []
    for pressure in (4e5, 8e5):
        measured = np.tile([0.1, pressure, 1e5], (200, 1))
        rates, _ = plant.along(
            measured, np.zeros(199), np.full(199, along.RESTS), np.tile(SHUT, (199, 1)), 1e-3
        )
        np.testing.assert_allclose(rates[:, along.SOURCE_1], rates[0, along.SOURCE_1], rtol=1e-3)
        assert np.abs(rates[:, along.SOURCE_2]).max() < 1e-15
        levels.append(rates[0, along.SOURCE_1])
    gas = model.gas
    k = gas.heat_capacity_ratio
    critical = (2.0 / (k + 1.0)) ** ((k + 1.0) / (2.0 * (k - 1.0)))
    closed = -2e-9 * 4e5 * critical * np.sqrt(k / (gas.gas_constant * gas.supply_temperature))
    # out of a chamber the gas takes the enthalpy of its own temperature, here that of the supply
    assert levels[0] == pytest.approx(closed, rel=5e-3)
    assert levels[1] == pytest.approx(2.0 * levels[0], rel=5e-3)


def test_force_of_a_sliding_piston_is_its_inertia(
    model: Model, case: tuple[Trajectory, Floats, Floats]
) -> None:
    run, _, rates = case
    force, inertia = rates[:, along.FORCE], rates[:, along.INERTIA]
    slides = np.isfinite(force) & (np.abs(run.velocity[1:]) > 0.02)
    assert slides.sum() > 5000
    np.testing.assert_allclose(inertia[slides], model.total_mass, rtol=1e-9)
    wanted = model.total_mass * np.diff(run.velocity) / FINE
    apart = np.abs(force - wanted)[slides]
    assert apart.max() < 0.02  # [N], of a friction of 4 N and more


def test_seal_is_loaded_fully_where_it_breaks_away(
    case: tuple[Trajectory, Floats, Floats],
) -> None:
    run, _, rates = case
    loading = rates[:, along.LOADING]
    moving = np.isnan(loading)
    starts = [0, *(np.flatnonzero(moving[:-1] & ~moving[1:]) + 1)]
    ends = np.flatnonzero(~moving[:-1] & moving[1:])
    pairs = list(zip(starts, ends, strict=True))
    rests = [(start, end) for start, end in pairs if end - start > LONG / FINE]
    assert len(rests) == 2
    for start, end in rests:
        assert run.contact[end] == 0
        assert loading[end] == pytest.approx(1.0, abs=0.05)
        assert (loading[start + round(LONG / FINE) : end] < 1.05).all()
        assert loading[start:end].min() < 0.8
    assert np.isnan(rates[~moving, along.FORCE]).all()
