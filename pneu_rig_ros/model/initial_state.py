"""The integration of a plant at rest, before its first step."""

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model import chambers, friction
from pneu_rig_ros.model.compiled_model import CompiledModel, air
from pneu_rig_ros.model.dynamics import (
    ANCHORS,
    ARROW_SIZE,
    GAS_MASS_1,
    HELD_DWELL,
    HELD_STATIC,
    POSITION,
    PRESSURE_1,
    REST_START,
    STICKING,
)
from pneu_rig_ros.model.integrator import AFTER_EVENT, IntegratorState
from pneu_rig_ros.model.parameters import Model
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE


def initial_state(
    model: Model, arguments: CompiledModel, size: int, temperatures: tuple[float, float]
) -> IntegratorState:
    """
    Return the carry of a piston that has rested for ``rest_time`` at its initial position.

    :param temperatures: of the gas in both chambers [K]
    """
    operation, law = model.operation, model.friction
    volumes = chambers.volumes(operation.initial_position, model.cylinder)
    pressures = operation.initial_pressure_1, operation.initial_pressure_2
    y1 = np.zeros(size)
    y1[POSITION] = operation.initial_position
    for i in range(2):
        mass = chambers.gas_mass(pressures[i], volumes[i], temperatures[i], arguments.gas)
        y1[PRESSURE_1 + i], y1[GAS_MASS_1 + i] = pressures[i], mass
    memory = np.zeros(ANCHORS + len(law.element_stiffness))
    memory[STICKING], memory[REST_START] = 1.0, -operation.rest_time
    memory[HELD_DWELL] = operation.rest_time
    memory[HELD_STATIC] = friction.static_friction(
        operation.rest_time, law.breakaway_force, law.coulomb_force, arguments.friction
    )
    return IntegratorState(
        clock=np.array([0.0, 0.0, AFTER_EVENT, 0.0]),
        counts=np.zeros(5, dtype=np.int64),
        y0=y1.copy(),
        f0=np.zeros(size),
        y1=y1,
        f1=np.zeros(size),
        arrow=np.zeros(ARROW_SIZE),
        memory=memory,
        voltages=np.full(2, CENTRE_VOLTAGE),
        scale=full_scale(model, size),
        work=np.zeros((5, size)),
        work_arrow=np.zeros(ARROW_SIZE),
    )


def full_scale(model: Model, size: int) -> Floats:
    """Return the full scale of each state, the unit of the local error, shape (size,)."""
    pressure = model.operation.supply_pressure
    stiffness = sum(model.friction.element_stiffness)
    level = max(model.friction.breakaway_force, model.friction.coulomb_force)
    cylinder = model.cylinder
    volume = cylinder.cap_dead_volume + cylinder.cap_area * cylinder.stroke
    mass = chambers.gas_mass(pressure, volume, model.gas.supply_temperature, air(model.gas))
    scale = np.ones(size)
    scale[:8] = cylinder.stroke, 1.0, pressure, pressure, level / stiffness, 1.0, mass, mass
    return scale
