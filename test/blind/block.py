"""Valve block: two valves that fill and empty two fixed volumes, voltages stepped and ramped."""

from collections.abc import Mapping

import numpy as np
from numpy.random import Generator

from pneu_rig_ros.scenarios.hidden import Secret

from .bags import DAC_STEP
from .imposed import CENTRE, at_zero
from .runs import Run
from .sealed import conductance, leak_area
from .settings import Settings, changed, settings
from .system import (
    CYLINDER_KEYS,
    GAS_KEYS,
    PRESSURE,
    Sensor,
    System,
    gas_recording,
    log_graded,
    log_uniform,
    names,
)

RATE, DURATION = 400.0, 20.0
"""Samples a second; length of a recording [s]."""
VALVE_KEYS = (
    'intake_coefficient',
    'exhaust_coefficient',
    'intake_voltage',
    'exhaust_voltage',
    'exhaust_zero_voltage',
    'laminar_pressure_ratio',
)
PARAMETERS = tuple(f'valve.{key}' for key in VALVE_KEYS[:4])
SHIFT = 0.01, 0.04
"""By how much an edge may be displaced [V]."""


def _sizes(random: Generator) -> Settings:
    edge = float(random.uniform(0.1, 0.2))
    volumes = [log_uniform(random, 5e-5, 2e-4) for _ in range(2)]
    stroke, area = 1e-2, 1e-4
    return changed(
        settings('cylinder_1'),
        {
            'cylinder.cap_area': area,
            'cylinder.rod_area': area,
            'cylinder.stroke': stroke,
            'cylinder.cap_dead_volume': volumes[0],
            'cylinder.rod_dead_volume': volumes[1],
            'valve.intake_coefficient': float(random.uniform(3e-8, 8e-8)),
            'valve.exhaust_coefficient': float(random.uniform(3e-8, 8e-8)),
            'valve.intake_voltage': CENTRE + edge,
            'valve.exhaust_voltage': CENTRE - edge,
            'valve.exhaust_zero_voltage': CENTRE - edge,
            'operation.supply_pressure': float(random.uniform(5e5, 8e5)),
        },
    )


def _strengths(grade: float, model: Settings) -> dict[str, dict[str, float]]:
    volume = model['cylinder']['cap_dead_volume'], model['cylinder']['rod_dead_volume']
    leak, heat = log_graded(grade, 300.0, 30.0), log_graded(grade, 20.0, 2.0)
    bent = 1.0 + log_graded(grade, 0.03, 0.4)
    return {
        'supply_droop': {'resistance': log_graded(grade, 2e8, 1.5e9)},
        'valve_lag': {'time_constant': log_graded(grade, 0.01, 0.1)},
        'spool_hysteresis': {'width': log_graded(grade, 0.01, 0.08)},
        'nonlinear_opening': {'intake_exponent': bent, 'exhaust_exponent': bent},
        'valve_null_leak': {
            'intake_area': log_graded(grade, 1e-10, 1e-9),
            'exhaust_area': log_graded(grade, 2e-10, 2e-9),
        },
        'chamber_leak': {
            'area_1': leak_area(volume[0], leak, model),
            'area_2': leak_area(volume[1], 0.6 * leak, model),
        },
        'wall_heat_transfer': {
            'conductance_1': conductance(volume[0], heat, model),
            'conductance_2': conductance(volume[1], 1.4 * heat, model),
        },
    }


def _wrong(name: str, grade: float, model: Settings) -> Secret:
    """Return the secret that a valve's parameter is too small in the model."""
    key = name.split('.')[1]
    value = model['valve'][key]
    if not key.endswith('voltage'):
        return Secret({}, {name: (1.1 + 0.1 * grade) * value}, {})
    truth = {name: value + float(np.interp(grade, (0.0, 2.0), SHIFT))}
    if key == 'exhaust_voltage':  # a land is displaced as a whole
        truth['valve.exhaust_zero_voltage'] = truth[name]
    return Secret({}, truth, {})


def voltages(model: Settings, random: Generator) -> np.ndarray:
    """
    Return the voltage of a valve in each interval [V]: fill, shut, empty, again and again.

    Each is reached by a step or a ramp and held for 0.3 to 1.5 s, shut for up to 2 s.
    """
    edges = model['valve']['exhaust_voltage'], model['valve']['intake_voltage']
    pieces, now = [np.full(round(0.5 * RATE), CENTRE)], CENTRE
    while sum(map(len, pieces)) < DURATION * RATE:
        kind = random.integers(3)
        opening = log_uniform(random, 0.02, 0.6)
        goal = (CENTRE, edges[1] + opening, edges[0] - opening)[kind]
        ramp = round(float(random.uniform(0.1, 1.0)) * RATE) * int(random.integers(2))
        pieces.append(np.linspace(now, goal, ramp))
        pieces.append(np.full(round(float(random.uniform(0.3, 1.5)) * RATE), goal))
        now = goal
    wanted = np.clip(np.concatenate(pieces)[: round(DURATION * RATE)], 0.0, 5.0)
    return np.round(wanted / DAC_STEP) * DAC_STEP


def _runs(
    true: Settings, model: Settings, hidden: Mapping[str, float], random: Generator
) -> list[Run]:
    runs = []
    for name in names():
        driven = np.stack([voltages(model, random) for _ in range(2)], axis=1)
        start = {f'initial_pressure_{i}': float(random.uniform(1e5, 4e5)) for i in (1, 2)}
        runs.append(
            gas_recording(name, true, model, hidden, at_zero, start, DURATION, RATE, None, driven)
        )
    return runs


def _sensors(model: Settings) -> dict[str, Sensor]:
    exact = Sensor(0.0, 0.0, 0.0)
    return {'pressure_1': PRESSURE, 'pressure_2': PRESSURE, 'voltage_1': exact, 'voltage_2': exact}


BLOCK = System(
    'valve_block',
    ('gas_1', 'gas_2'),
    (
        'supply_droop',
        'valve_lag',
        'spool_hysteresis',
        'nonlinear_opening',
        'valve_null_leak',
        'chamber_leak',
        'wall_heat_transfer',
        *PARAMETERS,
    ),
    _sizes,
    _strengths,
    _runs,
    _sensors,
    {
        'cylinder': CYLINDER_KEYS,
        'gas': GAS_KEYS,
        'valve': VALVE_KEYS,
        'operation': ('supply_pressure',),
    },
    {'fixed': {'position': '0 m'}},
    bag=True,
    wrong=_wrong,
)
