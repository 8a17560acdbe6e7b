"""A model under test: parameters, and the effects that are held to act."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.gap.experiment import Experiment
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.effect import GAS_BALANCES, READING_BALANCES
from pneu_rig_ros.model.parameters import Model
from pneu_rig_ros.model.plant import TOLERANCE, Plant

Floats = NDArray[np.float64]

Gains = tuple[float, float, float]
CALIBRATED: Gains = (1.0, 1.0, 1.0)
ROUGH = 1e-5
"""Tolerance of predictions that only have to be ranked, as a share of full scale [-]."""


@dataclass(frozen=True)
class Hypothesis:
    """
    What the rig is held to be.

    :param model: parameters; its operation is replaced by that of each experiment
    :param effects: name -> parameters of the effects that act
    :param gains: slopes of the sensors of x, p1, p2 [-]
    :param tolerance: of the simulation, as a share of full scale [-]
    """

    model: Model
    effects: Mapping[str, Any] = field(default_factory=dict)
    gains: Gains = CALIBRATED
    tolerance: float = TOLERANCE

    def plant(self, experiment: Experiment, shift: Floats) -> Plant:
        """
        Return the plant at the start of an experiment.

        :param shift: added to the readings of x, v, p1, p2 that it starts from [SI], shape (4,)

        """
        gas = self.model.gas._replace(atmospheric_pressure=experiment.atmospheric_pressure)
        stroke, start = self.model.cylinder.stroke, experiment.operation
        operation = start._replace(
            initial_position=float(np.clip(start.initial_position + shift[0], 0.0, stroke)),
            initial_pressure_1=start.initial_pressure_1 + shift[2],
            initial_pressure_2=start.initial_pressure_2 + shift[3],
        )
        return self.plant_of(self.model._replace(operation=operation, gas=gas))

    def plant_of(self, model: Model) -> Plant:
        """
        Return the plant of a model with the effects that act.

        It is the plant with every effect of the library, those that do not act with their null
        parameters, so that no other has to be compiled whatever is tried.
        """
        nulls = {name: library.load(name).null for name in library.names()}
        return Plant(model, {**nulls, **self.effects}, self.tolerance)

    def under(self, conditions: Mapping[str, float]) -> Hypothesis:
        """Return the hypothesis under conditions of ``records.conditions`` [SI]."""
        model, known = self.model, dict(conditions)
        gas = model.gas
        if 'atmospheric_pressure' in known:
            gas = gas._replace(atmospheric_pressure=known.pop('atmospheric_pressure'))
        operation = model.operation._replace(**known)
        return replace(self, model=model._replace(gas=gas, operation=operation))

    def roughly(self) -> Hypothesis:
        """Return the hypothesis for predictions that only have to be ranked."""
        return replace(self, tolerance=ROUGH)

    def forceless(self) -> Hypothesis:
        """Return the hypothesis without what shows in the motion alone, for one imposed."""
        kept = (*GAS_BALANCES, *READING_BALANCES)
        acting = self.effects.items()
        return replace(self, effects={n: p for n, p in acting if library.load(n).balance in kept})

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
