"""Outstrokes under the conditions of the paper's figures, simulated under one reading of it."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Any

import numpy as np

from pneu_rig_ros.analysis.stick_slip import Cycle, find_cycles
from pneu_rig_ros.batch.strokes import END_SHARE, strokes
from pneu_rig_ros.model.parameters import FRICTION_MODELS, Model
from pneu_rig_ros.model.plant import Plant, Trajectory
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.rig.valve_drive import valve_voltages

CYLINDERS = ('cylinder_1', 'cylinder_2', 'cylinder_3')
INTERVAL = 1.16e-3
"""Sampling interval [s], section 2.1 of the paper."""
LONGEST_STROKE = 100.0
"""A stroke is given up after this time [s]."""


@dataclass(frozen=True)
class Reading:
    """
    One choice of everything that the paper does not print.

    :param name: of the reading
    :param friction: fields of ``Friction`` that differ from the shipped files
    :param operation: ``rest_time`` [s] and ``initial_position`` [m] that differ
    :param single: name of a cylinder -> fields of ``Friction`` that differ for it alone
    """

    name: str = 'default'
    friction: Mapping[str, Any] = field(default_factory=dict)
    operation: Mapping[str, float] = field(default_factory=dict)
    single: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    def friction_of(self, cylinder: str) -> dict[str, Any]:
        """Return the fields of ``Friction`` that differ for a cylinder."""
        return {**self.friction, **self.single.get(cylinder, {})}


@dataclass(frozen=True)
class Experiment:
    """
    One outstroke from rest.

    :param cylinder: name of a shipped cylinder
    :param u: command of Eq. 1 [V]
    :param supply_pressure: absolute [Pa]
    :param load_mass: external load [kg]
    :param initial_position: [m], None for that of the reading
    :param law: name of the friction law
    """

    cylinder: str
    u: float
    supply_pressure: float = 5e5
    load_mass: float = 0.2
    initial_position: float | None = None
    law: str = 'revised_lugre_dwell'


CAPTIONS = {
    'cylinder_1': Experiment('cylinder_1', 0.29),
    'cylinder_2': Experiment('cylinder_2', 0.34),
    'cylinder_3': Experiment('cylinder_3', 0.32),
}
"""Operating points of Fig. 4-6."""


@dataclass(frozen=True)
class Stroke:
    """An experiment carried out, up to the end of the stroke."""

    experiment: Experiment
    run: Trajectory
    plant: Plant

    @cached_property
    def cycles(self) -> list[Cycle]:
        """Stick-slip cycles, from the position as the segmentation of a record finds them."""
        return find_cycles(self.run.position, INTERVAL, self.run.friction_force)

    @property
    def count(self) -> int:
        """Number of stick-slip cycles."""
        return len(self.cycles)

    @property
    def time(self) -> float:
        """Time to the end of the stroke [s], infinite if it was not reached."""
        return float(self.run.time[-1]) if self.finished else np.inf

    @property
    def finished(self) -> bool:
        """Whether the end of the stroke was reached."""
        stroke = self.plant.model.cylinder.stroke
        return bool(self.run.position[-1] >= END_SHARE * stroke)

    @property
    def start(self) -> float:
        """Initial position [m]."""
        return self.plant.model.operation.initial_position

    def column(self, name: str, first: int = 0) -> np.ndarray[Any, np.dtype[np.float64]]:
        """Return a field of all cycles from number ``first`` on, shape (n,)."""
        return np.array([getattr(cycle, name) for cycle in self.cycles[first:]])


class Laboratory:
    """
    Carries out experiments under one reading, each only once.

    :param reading: what the paper does not print
    :param tolerance: of the integration [-]
    """

    def __init__(self, reading: Reading | None = None, tolerance: float = 1e-5) -> None:
        self.reading = reading or Reading()
        self._tolerance = tolerance
        self._strokes: dict[Experiment, Stroke] = {}

    def perform(self, experiment: Experiment) -> Stroke:
        """Return the stroke of an experiment."""
        return self.perform_all([experiment])[0]

    def perform_all(self, experiments: Iterable[Experiment]) -> list[Stroke]:
        """Return the strokes of experiments; those not yet carried out share the processors."""
        wanted = list(experiments)
        new = [one for one in dict.fromkeys(wanted) if one not in self._strokes]
        plants = [self.plant(one) for one in new]
        voltages = np.array([valve_voltages(one.u) for one in new]).reshape(-1, 2)
        runs = strokes(plants, voltages, INTERVAL, LONGEST_STROKE)
        self._strokes |= dict(zip(new, map(Stroke, new, runs, plants), strict=True))
        return [self._strokes[one] for one in wanted]

    def captions(self, law: str = 'revised_lugre_dwell') -> list[Stroke]:
        """Return the strokes of Fig. 4-6 under a friction law."""
        return self.perform_all(replace(point, law=law) for point in CAPTIONS.values())

    def plant(self, experiment: Experiment) -> Plant:
        """Return the plant of an experiment, at rest at its start."""
        model = _shipped(experiment.cylinder)
        conditions = {
            **self.reading.operation,
            'supply_pressure': experiment.supply_pressure,
            'load_mass': experiment.load_mass,
        }
        if experiment.initial_position is not None:
            conditions['initial_position'] = experiment.initial_position
        operation = model.operation._replace(**conditions)
        law = FRICTION_MODELS.index(experiment.law)
        changes = self.reading.friction_of(experiment.cylinder)
        friction = model.friction._replace(**changes, model=law)
        changed = model._replace(operation=operation, friction=friction)
        return Plant(changed, tolerance=self._tolerance)


@cache
def _shipped(cylinder: str) -> Model:
    return load_configuration(cylinder).model
