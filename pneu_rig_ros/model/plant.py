"""The plant: the model of one rig, started from rest and driven by two valve voltages."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from pneu_rig_ros.arrays import Flags, Floats, Integers
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model import along, chambers
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model import layout as at
from pneu_rig_ros.model.assembly import assemble
from pneu_rig_ros.model.compiled_model import CompiledModel, compiled_model
from pneu_rig_ros.model.effect import READING_BALANCES
from pneu_rig_ros.model.integrator import EXTRA_NAMES, initial_state
from pneu_rig_ros.model.parameters import FRICTION_MODELS, Model
from pneu_rig_ros.model.shape import ACTS, rows, without_shape
from pneu_rig_ros.model.valve import FULL_VOLTAGE

TOLERANCE = 1e-6
"""Default local error, as a share of full scale [-]."""
LONGEST_STEP = 0.05
"""Default longest step [s]."""

FREE = (np.empty(0, dtype=np.int64), np.empty((0, 4)), np.empty(0))
"""Integers, measured states and rests of a run that nothing is imposed on."""


class PlantState(NamedTuple):
    """
    The true state of the plant at one instant, SI units, absolute pressures.

    The readings are what perfect converters make of it: the true values, unless an effect on a
    sensor is among those of the plant.
    """

    time: float
    position: float
    velocity: float
    acceleration: float
    pressure_1: float
    pressure_2: float
    friction_force: float
    deflection: float
    film: float
    gas_mass_1: float
    gas_mass_2: float
    sticking: bool
    contact: int
    dwell_time: float
    position_reading: float
    velocity_reading: float
    pressure_1_reading: float
    pressure_2_reading: float


class Trajectory(NamedTuple):
    """States at the sampling instants, fields of ``PlantState`` as arrays of shape (m,)."""

    time: Floats
    position: Floats
    velocity: Floats
    acceleration: Floats
    pressure_1: Floats
    pressure_2: Floats
    friction_force: Floats
    deflection: Floats
    film: Floats
    gas_mass_1: Floats
    gas_mass_2: Floats
    sticking: Flags
    contact: Integers
    dwell_time: Floats
    position_reading: Floats
    velocity_reading: Floats
    pressure_1_reading: Floats
    pressure_2_reading: Floats


class Plant:
    """
    Eq. 3-16 with optional effects, integrated in time.

    :param model: parameters of all sections
    :param effects: name -> parameters of each optional effect, with or without a ``Shape``
    :param tolerance: local error as a share of full scale [-]
    :param temperatures: of the gas in both chambers at the start [K]; the supply's if omitted
    :raises RigError: for an unknown effect, parameters of another, or a shape that it cannot have
    """

    def __init__(
        self,
        model: Model,
        effects: Mapping[str, Any] | None = None,
        tolerance: float = TOLERANCE,
        temperatures: tuple[float, float] | None = None,
    ) -> None:
        self.model = model
        self.tolerance, self.longest_step = tolerance, LONGEST_STEP
        chosen = dict(sorted((effects or {}).items()))
        self._chosen = tuple(without_shape(own) for own in chosen.values())
        self._library = loaded = [library.load(name) for name in chosen]
        for name, own, one in zip(chosen, self._chosen, loaded, strict=True):
            if type(own) is not one.parameters:
                raise RigError(f'effects.{name}: {own!r} are no parameters of it')
        self._effects = rows(zip(chosen, loaded, chosen.values(), strict=True))
        self.state_size = at.STATE_SIZE + sum(len(effect.states) for effect in loaded)
        sensing = [effect.balance in READING_BALANCES for effect in loaded]
        self._sensed = any(self._effects[sensing, ACTS])
        self._temperatures = temperatures or (model.gas.supply_temperature,) * 2
        assembled = assemble(tuple(chosen))
        self.right_hand_side, self._run, self._read, self._along = assembled
        self.reset()

    def reset(self) -> PlantState:
        """Go back to rest at the initial position; return the state there."""
        self._arguments = self._compiled_model()
        self._carry, self._index = self.initial_integrator_state(), 0
        end = self._carry.end
        self.right_hand_side(0.0, end, self._arguments)
        self._carry.counts[at.EVALUATIONS] += 1
        self._last_state = end.state[np.newaxis].copy()
        self._last_extra = np.array([[end.rate[at.VELOCITY], *end.memory[:3]]])
        return self.state

    def _compiled_model(self) -> CompiledModel:
        """Return the model; the dwell clock is that of an effect which the law is completed by."""
        law = self.model.friction
        for effect, own in zip(self._library, self._chosen, strict=True):
            if own != effect.null and FRICTION_MODELS[law.model] in effect.laws:
                law = law._replace(**{name: getattr(own, name) for name in effect.clock})
        return compiled_model(self.model._replace(friction=law), self._effects)

    def initial_integrator_state(self) -> at.IntegratorState:
        """Return the integration of the model at rest, before its first step."""
        return initial_state(self.model, self._arguments, self.state_size, self._temperatures)

    def change_operation(self, **changes: float) -> None:
        """Change the supply pressure [Pa] or load [kg] (fields of ``Operation``) under way."""
        self._carry.end.voltages[:] = np.nan  # the next run cuts the step under way
        operation = self.model.operation._replace(**changes)
        self.model = self.model._replace(operation=operation)
        self._arguments = self._compiled_model()

    def run(self, voltages: Floats, interval: float) -> Trajectory:
        """
        Hold each row of voltages for one interval; return the states after each.

        :param voltages: u1, u2 [V], shape (m, 2)
        :param interval: [s], the same in every call since the last reset
        :raises RigError: if a state is not finite
        """
        return self.run_imposed(voltages, interval, *FREE)

    def step(self, voltage_1: float, voltage_2: float, interval: float) -> PlantState:
        """Hold the voltages [V] for one interval [s]; return the state after it, as ``run``."""
        self._advance(np.array([[voltage_1, voltage_2]]), interval, *FREE)
        return self.state

    def run_imposed(
        self, voltages: Floats, interval: float, actions: Integers, measured: Floats, rests: Floats
    ) -> Trajectory:
        """
        Run on along a measured run; return the states after each interval.

        :param voltages: u1, u2 [V], shape (m, 2)
        :param interval: [s]
        :param actions: what to do before each interval, flags of ``Impose``, shape (m,)
        :param measured: x, v, p1, p2 [SI] that the actions use, shape (m, 4)
        :param rests: when the rest, or a missed slide, began [s since the reset], shape (m,)
        :raises RigError: if a state is not finite
        """
        first, count = self._index, len(voltages)
        states, extras = self._advance(voltages, interval, actions, measured, rests)
        time = (first + 1.0 + np.arange(count, dtype=np.float64)) * interval
        return self._trajectory(time, states, extras)

    def _advance(
        self, voltages: Floats, interval: float, *imposed: Floats | Integers
    ) -> tuple[Floats, Floats]:
        """Return the states after each interval, and what the integrator adds to them."""
        count, carry = len(voltages), self._carry
        states, extras = np.empty((count, self.state_size)), np.empty((count, len(EXTRA_NAMES)))
        runs = carry, interval, self._index, np.clip(voltages, 0.0, FULL_VOLTAGE), *imposed
        accuracy = self.tolerance, self.longest_step
        self._run(*runs, states, extras, *accuracy, self._arguments)
        start, end = carry.clock[: at.END + 1].tolist()
        if math.isinf(end):
            raise RigError(f'simulation failed at t = {start:.6g} s: non-finite state')
        if count:
            self._last_state, self._last_extra = states[-1:].copy(), extras[-1:].copy()
        self._index += count
        return states, extras

    def along(
        self,
        measured: Floats,
        velocity: Floats,
        contacts: Integers,
        voltages: Floats,
        interval: float,
    ) -> tuple[Floats, Floats]:
        """
        Return the modelled rates along a measured run, and by how much the sensors are off.

        :param measured: x, p1, p2 [SI], shape (n, 3)
        :param velocity: in each interval [m/s], shape (n - 1,)
        :param contacts: what the piston does in each interval, see ``along``, shape (n - 1,)
        :param voltages: u1, u2 [V] in each interval, shape (n - 1, 2)
        :param interval: [s]
        :return: rates in the middle of each interval, see ``along.SOURCE_1``, shape (n - 1, 5),
            and readings less true x, p1, p2 there, shape (n - 1, 3)
        """
        count, carry = len(contacts), self.initial_integrator_state()
        rates, bias = np.empty((count, along.COLUMNS)), np.zeros((count, 3))
        states = np.empty((count if self._sensed else 0, self.state_size))
        runs = measured, velocity, contacts, np.clip(voltages, 0.0, FULL_VOLTAGE)
        self._along(interval, *runs, rates, states, carry, self._arguments)
        if self._sensed:
            middles = (np.arange(count, dtype=np.float64) + 0.5) * interval
            bias = (self._readings(middles, states) - states[:, :4])[:, [0, 2, 3]]
        return rates, bias

    @property
    def state(self) -> PlantState:
        """The state at the present sampling instant."""
        x, v, p1, p2, *inner = self._last_state[0, : at.STATE_SIZE].tolist()
        acceleration, sticking, contact, rest_start = self._last_extra[0].tolist()
        force = self._friction(p1, p2, acceleration)
        time = float(self._carry.clock[at.NOW])
        rest = sticking != 0.0, int(contact), time - rest_start if sticking else 0.0
        now = self._carry.clock[at.NOW :]
        readings = self._readings(now, self._last_state)[0].tolist()
        values = (time, x, v, acceleration, p1, p2, force, *inner, *rest, *readings)
        return PlantState._make(values)

    @property
    def counts(self) -> dict[str, int]:
        """Work done since the reset: steps, rejected, evaluations, events."""
        names = ('steps', 'rejected', 'evaluations', 'events')
        return dict(zip(names, self._carry.counts.tolist(), strict=False))

    def _friction(self, pressure_1: Any, pressure_2: Any, acceleration: Any) -> Any:
        """Return F_r [N] by Eq. 8 from numbers or arrays."""
        cylinder, gas = self.model.cylinder, self._arguments.gas
        drive = chambers.driving_force(pressure_1, pressure_2, cylinder, gas)
        return drive - self.model.total_mass * acceleration

    def _readings(self, times: Floats, states: Floats) -> Floats:
        """Return the readings at times [s] of states, shape (m, n), as rows of x, v, p1, p2."""
        if not self._sensed:
            return states[:, :4]
        readings, scratch = np.empty((len(states), 4)), np.zeros(self.state_size)
        self._read(times, states, readings, scratch, self._arguments)
        return readings

    def _trajectory(self, time: Floats, states: Floats, extras: Floats) -> Trajectory:
        x, v, p1, p2, *inner = states.T[: at.STATE_SIZE]
        acceleration, sticking, contact, rest_start = extras.T
        force = self._friction(p1, p2, acceleration)
        dwell = np.where(sticking != 0.0, time - rest_start, 0.0)
        rest = sticking != 0.0, contact.astype(np.int64), dwell
        readings = self._readings(time, states).T
        values = (time, x, v, acceleration, p1, p2, force, *inner, *rest, *readings)
        return Trajectory._make(values)
