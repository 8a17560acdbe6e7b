"""A model under test: parameters, acting effects, gains of the sensors, true conditions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from pneu_rig_ros.diagnosis.run import Run
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.parameters import Model, Operation
from pneu_rig_ros.model.plant import TOLERANCE, Plant

Gains = tuple[float, float, float]
CALIBRATED: Gains = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Hypothesis:
    """
    A model of the system with its sensors.

    :param model: parameters; its operation is replaced by that of each recording
    :param effects: name -> parameters of the acting effects
    :param gains: slopes of the sensors of x, p1, p2 [-]
    :param conditions: condition of a recording -> ratio of its true to its stated value [-]
    """

    model: Model
    effects: Mapping[str, Any] = field(default_factory=dict)
    gains: Gains = CALIBRATED
    conditions: Mapping[str, float] = field(default_factory=dict)

    def plant_of(self, run: Run) -> Plant:
        """Return the plant in the state in which a run begins."""
        plant = self.plant(run, run.initial_operation)
        plant.start_with(run.gas_temperatures(self.model.gas))
        return plant

    def plant(self, run: Run, operation: Operation) -> Plant:
        """
        Return the plant in the surroundings of a run, under conditions as stated.

        It has every effect of the library, the others with their null parameters: one compiled
        right-hand side then serves all hypotheses.
        """
        true = {name: ratio * getattr(operation, name) for name, ratio in self.conditions.items()}
        gas = self.model.gas._replace(atmospheric_pressure=run.atmospheric_pressure)
        model = self.model._replace(operation=operation._replace(**true), gas=gas)
        nulls = {name: library.load(name).null for name in library.names()}
        return Plant(model, {**nulls, **self.effects}, TOLERANCE)

    def with_condition(self, name: str, ratio: float) -> Hypothesis:
        """Return the hypothesis with a ratio of the true to the stated condition [-]."""
        return replace(self, conditions={**self.conditions, name: ratio})

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
