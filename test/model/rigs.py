"""Plants for the tests: the shipped cylinders with a few parameters changed."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.model import effects
from pneu_rig_ros.model.parameters import FILM_RESTS_WITH_CLOCK, LATCHED_AT_BREAKAWAY, Model
from pneu_rig_ros.model.plant import Plant, Trajectory
from pneu_rig_ros.rig import load_configuration

CYLINDERS = ('cylinder_1', 'cylinder_2', 'cylinder_3')
CAPTION_COMMANDS = dict(zip(CYLINDERS, (0.29, 0.34, 0.32), strict=True))
"""u [V] of Fig. 4-6."""
INTERVAL = 1.16e-3
SHUT = (2.5, 2.5)


PLAIN: dict[str, dict[str, Any]] = {
    'friction': {
        'element_stiffness': (6e4,),
        'element_limit': (),
        'stop_velocity': 7.5e-4,
        'start_velocity': 5.5e-3,
        'film_rest_reading': FILM_RESTS_WITH_CLOCK,
        'film_rest_velocity': 1e-3,
        'static_friction_reading': LATCHED_AT_BREAKAWAY,
        'fluid_time_constant': 0.0,
    },
    'valve': {'exhaust_zero_voltage': 2.35},
    'operation': {'supply_pressure': 5e5, 'initial_position': 0.0, 'rest_time': 1060.0},
}
"""What the paper leaves open, as plain as it can be read: closed forms are known for it."""


def changed(cylinder: str, **sections: dict[str, Any]) -> Model:
    """Return a shipped cylinder under the plain reading, fields of its sections replaced."""
    model = load_configuration(cylinder).model
    for name, fields in (*PLAIN.items(), *sections.items()):
        model = model._replace(**{name: getattr(model, name)._replace(**fields)})
    return model


def with_effects(**given: tuple[float, ...]) -> dict[str, Any]:
    """Return the parameters of all effects, null but for the values that are given in order."""
    chosen = {name: effects.load(name).parameters(*values) for name, values in given.items()}
    return effects.nulls() | chosen


def plant_with(
    name: str,
    *values: float,
    temperatures: tuple[float, float] | None = None,
    **sections: dict[str, Any],
) -> Plant:
    """Return the plant that all effects share, one of them switched on."""
    model = changed('cylinder_2', **sections)
    return Plant(model, with_effects(**{name: values}), temperatures=temperatures)


def drive(
    plant: Plant, voltages: tuple[float, float], duration: float, interval: float = INTERVAL
) -> Trajectory:
    """Hold the voltages for the duration and return the samples."""
    return plant.run(np.tile(voltages, (round(duration / interval), 1)), interval)


def stroke(plant: Plant, u: float, duration: float) -> Trajectory:
    """Run an outstroke at the command u."""
    return drive(plant, (2.5 + u, 2.5 - u), duration)


def worst(a: NDArray[np.float64], b: NDArray[np.float64], full_scale: float) -> float:
    """Return the largest difference as a share of full scale."""
    return float(np.abs(a - b).max() / full_scale)
