"""
Seal bench: a piston driven from outside against a constant pressure, the force on it measured.

The bench pushes against chamber 2; chamber 1 is open. The zero of the force sensor differs from
recording to recording.
"""

from collections.abc import Mapping

import numpy as np
from numpy.random import Generator

from . import constants as at
from .along import friction_along
from .contributions import Equations, driving
from .imposed import CENTRE
from .runs import Noise, Run, equations
from .settings import Settings, changed, settings
from .system import ATMOSPHERE, PRESSURE, Sensor, System, log_graded, names

RATE, EVERY, DURATION = 100.0, 40, 40.0
"""Samples a second; steps of the equations for each; length of a recording [s]."""
FORCE = Sensor(-50.0, 300.0, 0.05)
POSITION = Sensor(0.0, 24e-3, 2e-6)
LOW, HIGH = 2e-3, 22e-3
"""Ends of the long strokes [m]."""
SLOWEST, FASTEST = 2e-3, 15e-3
"""Speeds of the piston [m/s]."""
REVERSALS = 1.5e-4, 5e-4
"""Lengths of the short strokes that end a recording [m]."""
FRICTION_KEYS = (
    'model',
    'coulomb_force',
    'viscous_coefficient',
    'micro_viscous_coefficient',
    'element_stiffness',
    'element_limit',
    'stop_velocity',
    'start_velocity',
)


def _sizes(random: Generator) -> Settings:
    coulomb, area = float(random.uniform(3.0, 9.0)), float(random.uniform(1e-4, 3e-4))
    return changed(
        settings('cylinder_1'),
        {
            'cylinder.cap_area': area,
            'cylinder.rod_area': area,
            'cylinder.stroke': float(random.uniform(0.024, 0.04)),
            'cylinder.moving_mass': 0.0,
            'operation.load_mass': 0.0,
            'friction.model': 'coulomb_viscous',
            'friction.coulomb_force': coulomb,
            'friction.breakaway_force': 2.0 * coulomb,
            'friction.stribeck_velocity': 6e-3,
            'friction.viscous_coefficient': float(random.uniform(0.0, 200.0)),
            'friction.micro_viscous_coefficient': 0.0,
            'friction.element_stiffness': [float(random.uniform(2e4, 8e4))],
        },
    )


def _strengths(grade: float, model: Settings) -> dict[str, dict[str, float]]:
    return {
        'pressure_dependent_friction': {'slope': log_graded(grade, 2e-6, 2e-5)},
        'direction_dependent_friction': {'asymmetry': log_graded(grade, 0.04, 0.35)},
        'position_dependent_friction': {'gradient': log_graded(grade, 0.1, 0.8)},
        'friction_warm_up': {'drop': log_graded(grade, 0.1, 0.5), 'work': 0.5},
        'load_spring': {'stiffness': log_graded(grade, 10.0, 150.0), 'compression': 0.02},
    }


def strokes(random: Generator) -> np.ndarray:
    """Return the positions at the fine steps [m]: strokes at constant speeds, short ones last."""
    times, places = [0.0, 1.0], [LOW, LOW]
    while times[-1] < 0.8 * DURATION:
        goal = HIGH if places[-1] == LOW else LOW
        speed = float(random.uniform(SLOWEST, FASTEST))
        times.append(times[-1] + abs(goal - places[-1]) / speed)
        places.append(goal)
    side = -1.0 if places[-1] == HIGH else 1.0
    while times[-1] < DURATION:
        way = float(random.uniform(*REVERSALS))
        times.append(times[-1] + way / SLOWEST)
        places.append(places[-1] + side * way)
        side = -side
    return np.interp(_fine(), times, places)


def sines(random: Generator) -> np.ndarray:
    """Return the positions at the fine steps [m]: a sine that begins at rest, growing faster."""
    t = np.maximum(_fine() - 1.0, 0.0)
    omega = float(random.uniform(0.3, 0.6)) * (1.0 + t / DURATION)
    return LOW + 0.5 * (HIGH - LOW) * (1.0 - np.cos(omega * t))


def _fine() -> np.ndarray:
    """Return the times of the fine steps [s]."""
    return np.arange(round(DURATION * RATE) * EVERY + 1) / (RATE * EVERY)


def _states(positions: np.ndarray, gauge: float) -> np.ndarray:
    states = np.zeros((len(positions), at.STATES))
    states[:, at.X] = positions
    states[1:, at.V] = np.diff(positions) * RATE * EVERY
    states[:, at.P1], states[:, at.P2] = ATMOSPHERE, ATMOSPHERE + gauge
    return states


def needed(states: np.ndarray, side: Equations) -> np.ndarray:
    """Return the force from outside along the outstroke [N], shape (n,)."""
    moves = np.zeros(len(states), dtype=bool)
    return friction_along(states, moves, 0.0, 1.0 / (RATE * EVERY), *side) - driving(states, side)


def _runs(
    true: Settings, model: Settings, hidden: Mapping[str, float], random: Generator
) -> list[Run]:
    runs, gauges = [], 1e5 * random.permutation([1.0, 3.0, 5.0, 2.0, 6.0])
    sides = equations(true, hidden), equations(model, {})
    noise = Noise(POSITION.deviation, PRESSURE.deviation, FORCE.deviation)
    for index, (name, gauge) in enumerate(zip(names(), gauges, strict=True)):
        way = (sines if index % 2 else strokes)(random)
        states = _states(way, float(gauge))
        zero = float(random.uniform(-3.0, 3.0))
        force = needed(states, sides[0])[::EVERY] + zero
        runs.append(
            Run(
                name,
                1.0 / RATE,
                states,
                np.zeros(len(states), dtype=bool),
                np.full((len(states), 2), CENTRE),
                *sides,
                {},
                noise,
                0.0,
                EVERY,
                force,
            )
        )
    return runs


BENCH = System(
    'seal_bench',
    ('force',),
    (
        'pressure_dependent_friction',
        'direction_dependent_friction',
        'position_dependent_friction',
        'friction_warm_up',
        'stribeck',
        'presliding_hysteresis',
        'load_spring',
        'friction.coulomb_force',
    ),
    _sizes,
    _strengths,
    _runs,
    lambda model: {'position': POSITION, 'pressure_2': PRESSURE, 'force': FORCE},
    {
        'cylinder': ('cap_area', 'rod_area', 'stroke'),
        'friction': FRICTION_KEYS,
        'gas': ('atmospheric_pressure',),
    },
    {'each_recording': ['force_offset']},
)
