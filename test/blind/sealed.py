"""
Sealed gas: two chambers on a piston that is moved from outside, and one leaking vessel.

From a cylinder of the laboratory to the bench of a wave energy converter, filled with one of four
gases; the gas has the temperature of the walls when a recording begins, but for a vessel that was
just filled.
"""

from collections.abc import Mapping

import numpy as np
from numpy.random import Generator

from .imposed import at_zero, steps, waves
from .runs import Run
from .settings import Settings, changed, settings
from .system import (
    CYLINDER_KEYS,
    GAS_KEYS,
    PRESSURE,
    System,
    gas_recording,
    log_graded,
    log_uniform,
    names,
    position_sensor,
)

GASES = {
    'air': (287.0, 1.3997),
    'nitrogen': (296.8, 1.4),
    'argon': (208.1, 1.667),
    'helium': (2077.0, 1.667),
}
"""Gas constant [J/(kg K)], heat capacity ratio [-]."""
SEALED_RATE, VESSEL_RATE = 50.0, 10.0
"""Samples a second."""
VESSEL_TIME = 150.0
"""Length of a recording [s]."""
WARM = 330.0
"""Temperature of the gas in a vessel that was just filled [K]."""
FULL = 3e5
"""A pressure for which strengths are worked out [Pa]."""


def _sizes(random: Generator) -> Settings:
    area, stroke = log_uniform(random, 5e-4, 1.3e-2), log_uniform(random, 0.2, 2.0)
    rod = area * float(random.uniform(0.8, 0.95))
    gas_constant, ratio = list(GASES.values())[random.integers(len(GASES))]
    dead = [float(random.uniform(0.5, 1.5)) * a * stroke for a in (area, rod)]
    return changed(
        settings('cylinder_1'),
        {
            'cylinder.cap_area': area,
            'cylinder.rod_area': rod,
            'cylinder.stroke': stroke,
            'cylinder.cap_dead_volume': dead[0],
            'cylinder.rod_dead_volume': dead[1],
            'gas.gas_constant': gas_constant,
            'gas.heat_capacity_ratio': ratio,
            'gas.supply_temperature': float(random.uniform(288.0, 300.0)),
        },
    )


def _vessel(random: Generator) -> Settings:
    volume = log_uniform(random, 2e-5, 1e-3)
    changes = {'cylinder.cap_dead_volume': volume, 'gas.supply_temperature': 295.0}
    return changed(settings('cylinder_1'), changes)


def leak_area(volume: float, time: float, model: Settings) -> float:
    """Return the area [m^2] that empties a volume with a time constant, choked flow [s]."""
    k, r = model['gas']['heat_capacity_ratio'], model['gas']['gas_constant']
    choked = (2.0 / (k + 1.0)) ** ((k + 1.0) / (2.0 * (k - 1.0)))
    speed = choked * np.sqrt(k * r * model['gas']['supply_temperature'])
    return float(volume / (speed * time))


def conductance(volume: float, time: float, model: Settings) -> float:
    """Return the conductance [W/K] by which a gas at ``FULL`` takes the walls' temperature."""
    gas = model['gas']
    capacity = FULL * volume / (gas['supply_temperature'] * (gas['heat_capacity_ratio'] - 1.0))
    return capacity / time


def _volumes(model: Settings) -> tuple[float, float]:
    """Return the volumes of both chambers at half the stroke [m^3]."""
    c = model['cylinder']
    half = 0.5 * c['stroke']
    return (
        c['cap_dead_volume'] + half * c['cap_area'],
        c['rod_dead_volume'] + half * c['rod_area'],
    )


def _strengths(grade: float, model: Settings) -> dict[str, dict[str, float]]:
    first, second = _volumes(model)
    leak, heat = log_graded(grade, 600.0, 60.0), log_graded(grade, 60.0, 4.0)
    return {
        'wall_heat_transfer': {
            'conductance_1': conductance(first, heat, model),
            'conductance_2': conductance(second, 1.4 * heat, model),
        },
        'cross_piston_leak': {'area': leak_area(min(first, second), leak, model)},
        'chamber_leak': {
            'area_1': leak_area(first, leak, model),
            'area_2': leak_area(second, 0.6 * leak, model),
        },
        'position_scale': {'error': log_graded(grade, 0.003, 0.03)},
        'pressure_offset': {
            'offset_1': log_graded(grade, 2e3, 1.2e4),
            'offset_2': -log_graded(grade, 1e3, 6e3),
        },
    }


def _strengths_in_vessel(grade: float, model: Settings) -> dict[str, dict[str, float]]:
    volume = model['cylinder']['cap_dead_volume']
    return {
        'chamber_leak': {'area_1': leak_area(volume, log_graded(grade, 2000.0, 100.0), model)},
        'wall_heat_transfer': {
            'conductance_1': conductance(volume, log_graded(grade, 4.0, 25.0), model),
        },
    }


def _sealed_runs(
    true: Settings, model: Settings, hidden: Mapping[str, float], random: Generator
) -> list[Run]:
    stroke, runs = model['cylinder']['stroke'], []
    for index, name in enumerate(names()):
        duration = float(random.uniform(60.0, 140.0))
        path = steps(stroke, duration, random) if index % 2 else waves(stroke, random)
        fill = {f'initial_pressure_{i}': float(random.uniform(2e5, 4.5e5)) for i in (1, 2)}
        run = gas_recording(name, true, model, hidden, path, fill, duration, SEALED_RATE)
        runs.append(run)
    return runs


def _vessel_runs(
    true: Settings, model: Settings, hidden: Mapping[str, float], random: Generator
) -> list[Run]:
    warm = WARM if 'wall_heat_transfer.conductance_1' in hidden else None
    runs = []
    for name in names():
        fill = {'initial_pressure_1': float(random.uniform(3e5, 9e5))}
        run = gas_recording(
            name, true, model, hidden, at_zero, fill, VESSEL_TIME, VESSEL_RATE, warm
        )
        runs.append(run)
    return runs


SEALED = System(
    'sealed_chambers',
    ('gas_1', 'gas_2'),
    (
        'wall_heat_transfer',
        'cross_piston_leak',
        'chamber_leak',
        'position_scale',
        'pressure_offset',
        'cylinder.cap_dead_volume',
        'cylinder.rod_dead_volume',
    ),
    _sizes,
    _strengths,
    _sealed_runs,
    lambda model: {
        'position': position_sensor(model),
        'pressure_1': PRESSURE,
        'pressure_2': PRESSURE,
    },
    {'cylinder': CYLINDER_KEYS, 'gas': GAS_KEYS},
    {'valve': 'shut'},
)
VESSEL = System(
    'leaking_chamber',
    ('gas_1',),
    ('chamber_leak', 'wall_heat_transfer'),
    _vessel,
    _strengths_in_vessel,
    _vessel_runs,
    lambda model: {'pressure_1': PRESSURE},
    {'cylinder': ('cap_dead_volume',), 'gas': GAS_KEYS},
    {'valve': 'shut', 'fixed': {'position': '0 m'}},
)
