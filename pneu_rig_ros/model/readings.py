"""
What the sensors read of a state: the true values and the contributions of the sensor effects.

Noise, quantisation and calibration come after it, see ``rig.sensors``.
"""

from collections.abc import Callable

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled import compiled, inner
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.contributions import Contributions
from pneu_rig_ros.model.dynamics import (
    DEFLECTION,
    POSITION,
    PRESSURE_1,
    PRESSURE_2,
    VELOCITY,
    signals_of,
)
from pneu_rig_ros.model.effect import Balance, Ports, Seal, Signals

Readings = Callable[..., None]


@compiled
def visible(time: float, state: Floats, model: CompiledModel) -> Signals:
    """Return the signals that follow from time [s] and state alone; the others are NaN."""
    supply = model.operation.supply_pressure
    ports = Ports(np.nan, np.nan, supply, supply)
    seal = Seal(state[DEFLECTION], np.nan, False, np.nan, np.nan, np.nan)
    return signals_of(time, state, ports, seal, model)


def build_readings(contributions: Contributions) -> Readings:
    """
    Return the compiled readings.

    ``readings(times, states, out, scratch, model, effects)`` writes the readings of x [m], v
    [m/s], p1 and p2 [Pa, absolute] at each of ``times`` [s], shape (m,), and row of ``states``,
    shape (m, n), into ``out``, shape (m, 4), and rates that are not needed into ``scratch``, shape
    (n,).
    """
    add_motion = contributions[Balance.MOTION_READING]
    add_pressure = contributions[Balance.PRESSURE_READING]

    @inner
    def readings(
        times: Floats,
        states: Floats,
        out: Floats,
        scratch: Floats,
        model: CompiledModel,
        effects: tuple[object, ...],
    ) -> None:
        for i in range(len(states)):
            state = states[i]
            signals = visible(times[i], state, model)
            position, velocity = add_motion(signals, model, effects, state, scratch)
            pressure_1, pressure_2 = add_pressure(signals, model, effects, state, scratch)
            out[i, 0], out[i, 1] = state[POSITION] + position, state[VELOCITY] + velocity
            out[i, 2] = state[PRESSURE_1] + pressure_1
            out[i, 3] = state[PRESSURE_2] + pressure_2

    return readings
