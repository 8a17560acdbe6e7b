"""A model under test: parameters, the effects that are held to act, the gains of the sensors."""

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
    What the system is held to be.

    :param model: parameters; its operation is replaced by that of each recording
    :param effects: name -> parameters of the effects that act
    :param gains: slopes of the sensors of x, p1, p2 [-]
    :param conditions: condition of a recording -> how many times what it states it is [-]
    """

    model: Model
    effects: Mapping[str, Any] = field(default_factory=dict)
    gains: Gains = CALIBRATED
    conditions: Mapping[str, float] = field(default_factory=dict)

    def plant_of(self, run: Run) -> Plant:
        """Return the plant as it was when a run began."""
        plant = self.plant(run, run.started(run.operation))
        plant.start_with(run.gas_temperatures(self.model.gas))
        return plant

    def plant(self, run: Run, operation: Operation) -> Plant:
        """
        Return the plant in the surroundings of a run under conditions as they are stated.

        It is the plant with every effect of the library, those that do not act with their null
        parameters, so that no other has to be compiled whatever is tried.
        """
        true = {name: times * getattr(operation, name) for name, times in self.conditions.items()}
        gas = self.model.gas._replace(atmospheric_pressure=run.atmospheric_pressure)
        model = self.model._replace(operation=operation._replace(**true), gas=gas)
        nulls = {name: library.load(name).null for name in library.names()}
        return Plant(model, {**nulls, **self.effects}, TOLERANCE)

    def with_condition(self, name: str, times: float) -> Hypothesis:
        """Return the hypothesis that a condition is so many times what was stated [-]."""
        return replace(self, conditions={**self.conditions, name: times})

    def with_effect(self, name: str, parameters: Any) -> Hypothesis:
        """Return the hypothesis that an effect acts too."""
        return replace(self, effects={**self.effects, name: parameters})

    def with_parameter(self, section: str, name: str, value: object) -> Hypothesis:
        """
        Return the hypothesis that a parameter of the model has another value [SI].

        With the edge of the exhaust all of its opening moves: a land is displaced as a whole.
        """
        old = getattr(self.model, section)
        changed = old._replace(**{name: value})
        if name == 'exhaust_voltage':
            jump = old.exhaust_zero_voltage - old.exhaust_voltage
            zero = changed.exhaust_voltage + jump
            changed = changed._replace(exhaust_zero_voltage=zero)
        return replace(self, model=self.model._replace(**{section: changed}))
