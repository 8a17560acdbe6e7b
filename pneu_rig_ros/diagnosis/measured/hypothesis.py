"""A model under test: parameters, acting effects, gains of the sensors, true conditions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.parameters import Model, Operation
from pneu_rig_ros.model.plant import TOLERANCE, Plant
from pneu_rig_ros.rig.configuration import REPEATABILITY

Gains = tuple[float, float, float]
CALIBRATED: Gains = (1.0, 1.0, 1.0)
POSITION_ZERO, SENSOR_CLOCK = 'position_zero', 'clock_offset'
"""
Conditions that are differences: reading of the position at the inner end [m], and by how much the
clock of the sensors is ahead of that of the commands [s].
"""


@dataclass(frozen=True)
class Hypothesis:
    """
    A model of the system with its sensors.

    :param model: parameters; its operation is replaced by that of each recording
    :param effects: name -> parameters of the acting effects
    :param gains: slopes of the sensors of x, p1, p2 [-]
    :param pressure_offsets: what those of p1, p2 read too much [Pa]
    :param conditions: condition of a recording -> ratio of its true to its stated value [-], or
        the difference of ``POSITION_ZERO`` or ``SENSOR_CLOCK``
    """

    model: Model
    effects: Mapping[str, Any] = field(default_factory=dict)
    gains: Gains = CALIBRATED
    pressure_offsets: tuple[float, float] = (0.0, 0.0)
    conditions: Mapping[str, float] = field(default_factory=dict)

    def plant_of(self, run: Run) -> Plant:
        """Return the plant in the state in which a run begins."""
        temperatures = run.gas_temperatures(self.model.gas)
        return self.plant(run, run.initial_operation, temperatures)

    def plant(
        self, run: Run, operation: Operation, temperatures: tuple[float, float] | None = None
    ) -> Plant:
        """
        Return the plant in the surroundings of a run, under conditions as stated.

        It has every effect of the library, the others with their null parameters: one compiled
        right-hand side then serves all hypotheses.

        :param temperatures: of the gas at the start [K], see ``Plant``
        """
        true = {
            name: ratio * getattr(operation, name)
            for name, ratio in self.conditions.items()
            if name in Operation._fields
        }
        gas = self.model.gas._replace(atmospheric_pressure=run.atmospheric_pressure)
        model = self.model._replace(operation=operation._replace(**true), gas=gas)
        effects = {**library.nulls(), **self.effects}
        return Plant(model, effects, TOLERANCE, temperatures=temperatures)

    @property
    def offsets(self) -> tuple[float, float, float]:
        """What the sensors of x, p1, p2 read too much [m, Pa, Pa]."""
        return self.conditions.get(POSITION_ZERO, 0.0), *self.pressure_offsets

    def voltages(self, run: Run) -> Floats:
        """Return u1, u2 in the intervals of a run by the clock of its sensors, (n - 1, 2) [V]."""
        shift = self.conditions.get(SENSOR_CLOCK, 0.0) / run.interval
        if shift == 0.0:
            return run.voltages
        # a fraction of an interval mixes neighbours, so that a fit sees how the clock matters
        index = np.arange(run.size - 1) - shift
        columns = [np.interp(index, np.arange(run.size - 1), u) for u in run.voltages.T]
        return np.column_stack(columns)

    def with_condition(self, name: str, value: float) -> Hypothesis:
        """Return the hypothesis with another condition, as in ``conditions``."""
        return replace(self, conditions={**self.conditions, name: value})

    def varied(self, name: str, by: float) -> Hypothesis:
        """Return the hypothesis with more of what may differ between recordings."""
        if REPEATABILITY[name].unit != '-':
            return self.with_condition(name, self.conditions.get(name, 0.0) + by)
        if hasattr(self.model.friction, name):
            value = (1.0 + by) * getattr(self.model.friction, name)
            return self.with_parameter('friction', name, value)
        return self.with_condition(name, self.conditions.get(name, 1.0) * (1.0 + by))

    def with_friction_level(self, factor: float) -> Hypothesis:
        """Return the hypothesis with both Coulomb and breakaway force multiplied."""
        friction, changed = self.model.friction, self
        for name in ('coulomb_force', 'breakaway_force'):
            changed = changed.with_parameter('friction', name, factor * getattr(friction, name))
        return changed

    def with_effect(self, name: str, parameters: Any) -> Hypothesis:
        """Return the hypothesis with one more acting effect."""
        return replace(self, effects={**self.effects, name: parameters})

    def with_parameter(self, section: str, name: str, value: object) -> Hypothesis:
        """
        Return the hypothesis with another value of a parameter [SI].

        The whole opening of the exhaust moves with its edge: a land is displaced as a whole.
        """
        old = getattr(self.model, section)
        changed = old._replace(**{name: value})
        if name == 'exhaust_voltage':
            jump = old.exhaust_zero_voltage - old.exhaust_voltage
            zero = changed.exhaust_voltage + jump
            changed = changed._replace(exhaust_zero_voltage=zero)
        return replace(self, model=self.model._replace(**{section: changed}))
