"""Outstrokes under the conditions of the paper's figures: simulated under a reading, measured."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Any

import numpy as np

from pneu_rig_ros.analysis.motion import Cycle, find_cycles
from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.batch import END_SHARE, strokes
from pneu_rig_ros.model.parameters import FRICTION_MODELS, Model
from pneu_rig_ros.model.plant import Plant, Trajectory
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.rig.valve_drive import valve_voltages

CYLINDERS = ('cylinder_1', 'cylinder_2', 'cylinder_3')
INTERVAL = 1.16e-3
"""Sampling interval [s], section 2.1 of the paper."""
LONGEST_STROKE = 200.0
"""A stroke is given up after this time [s]."""
CAPTION_SUPPLY = 4.0
"""Supply pressure in the captions of Fig. 4-6 and 9 [bar]."""
BAR = 1e5
"""[Pa]"""
TOLERANCE = 1e-5
"""Of the integration [-]."""

Changes = Mapping[str, Mapping[str, Any]]
"""Section of the model -> field -> value."""


@dataclass(frozen=True)
class Reading:
    """
    One choice of everything that the paper does not print, and possibly of printed values.

    :param name: of the reading
    :param common: what differs from the shipped files, for all cylinders
    :param single: name of a cylinder -> what differs for it alone
    """

    name: str = 'default'
    common: Changes = field(default_factory=dict)
    single: Mapping[str, Changes] = field(default_factory=dict)

    def model(self, cylinder: str) -> Model:
        """Return the model of a shipped cylinder under this reading."""
        model = shipped(cylinder)
        for changes in (self.common, self.single.get(cylinder, {})):
            for section, values in changes.items():
                changed = getattr(model, section)._replace(**values)
                model = model._replace(**{section: changed})
        return model


@dataclass(frozen=True)
class Conditions:
    """
    How an experiment is carried out, compared with what the paper prints.

    :param command: factor on u [-]
    :param supply: factor on the absolute supply pressure [-]
    :param start: initial position as a share of the stroke [-]; None for that of the reading
    """

    command: float = 1.0
    supply: float = 1.0
    start: float | None = None


@dataclass(frozen=True)
class Experiment:
    """
    One outstroke from rest.

    :param cylinder: name of a shipped cylinder
    :param u: command of Eq. 1 [V]
    :param supply: supply pressure as the paper prints it [bar]; the reading says whether that is
        absolute, by its ``supply_pressure`` for the 4 bar of the captions
    :param load_mass: external load [kg]
    :param start: initial position as a share of the stroke [-], None for that of the conditions
    :param law: name of the friction law
    """

    cylinder: str
    u: float
    supply: float = CAPTION_SUPPLY
    load_mass: float = 0.2
    start: float | None = None
    law: str = 'revised_lugre_dwell'


CAPTIONS = {
    'cylinder_1': Experiment('cylinder_1', 0.29),
    'cylinder_2': Experiment('cylinder_2', 0.34),
    'cylinder_3': Experiment('cylinder_3', 0.32),
}
"""Operating points of Fig. 4-6."""


@dataclass(frozen=True)
class Stroke:
    """An experiment carried out, up to the end of the stroke, and what is measured on it."""

    experiment: Experiment
    run: Trajectory
    plant: Plant

    @cached_property
    def cycles(self) -> list[Cycle]:
        """Stick-slip cycles, from the position alone."""
        return find_cycles(self.run.position, INTERVAL, self.run.friction_force)

    @property
    def count(self) -> int:
        """Number of stick-slip cycles."""
        return len(self.cycles)

    def column(self, name: str, first: int = 0) -> Floats:
        """Return a field of all cycles from number ``first`` on, shape (n,)."""
        return np.array([getattr(cycle, name) for cycle in self.cycles[first:]], dtype=float)

    @property
    def time(self) -> float:
        """Time to the end of the stroke [s], infinite if it was not reached."""
        end = END_SHARE * self.plant.model.cylinder.stroke
        return float(self.run.time[-1]) if self.run.position[-1] >= end else np.inf

    @property
    def start(self) -> float:
        """Initial position [m]."""
        return self.plant.model.operation.initial_position

    @property
    def dwells(self) -> Floats:
        """Dwell times between slips [s]: all but the rest before the first."""
        return self.column('dwell', 1)

    @property
    def median_dwell(self) -> float:
        """Median of the dwell times between slips [s], NaN of none."""
        return middle(self.dwells)

    @property
    def median_slip(self) -> float:
        """Median slip [mm] but for the first, from rest, and the last, into the end."""
        return 1e3 * middle(self.column('slip', 1)[:-1])

    def rest_share(self, to_end: bool = False) -> float:
        """Return the share at rest of the time from the first to the last slip, or the end [-]."""
        breakaways = self.column('breakaway_time')
        if len(breakaways) < 2:
            return 0.0
        last = self.run.time[-1] if to_end else breakaways[-1]
        return float(self.dwells.sum() / (last - breakaways[0]))

    @property
    def reach(self) -> float:
        """Share of the way covered at which the last slip begins [-]."""
        if not self.cycles:
            return 0.0
        last = np.interp(self.cycles[-1].breakaway_time, self.run.time, self.run.position)
        return float((last - self.start) / (self.run.position[-1] - self.start))


def medians(strokes: Sequence[Stroke]) -> tuple[list[float], list[float]]:
    """Return the median dwell [s] and the median slip [mm] of each stroke."""
    return [one.median_dwell for one in strokes], [one.median_slip for one in strokes]


def middle(values: Floats) -> float:
    """Return the median, NaN of nothing."""
    return float(np.median(values)) if len(values) else np.nan


class Laboratory:
    """
    Carries out experiments under one reading, each only once.

    :param reading: what the paper does not print
    :param conditions: how the experiments are carried out
    :param threads: at most, None for all processors
    :param cylinders: measured where a statement is about all of them
    """

    def __init__(
        self,
        reading: Reading | None = None,
        conditions: Conditions | None = None,
        threads: int | None = None,
        cylinders: Sequence[str] = CYLINDERS,
    ) -> None:
        self.reading = reading or Reading()
        self.conditions = conditions or Conditions()
        self.cylinders = tuple(cylinders)
        self._threads = threads
        self._strokes: dict[Experiment, Stroke] = {}

    def perform(self, experiment: Experiment) -> Stroke:
        """Return the stroke of an experiment."""
        return self.perform_all([experiment])[0]

    def perform_all(self, experiments: Iterable[Experiment]) -> list[Stroke]:
        """Return the strokes of experiments; those not yet carried out share the processors."""
        wanted = list(experiments)
        new = [each for each in dict.fromkeys(wanted) if each not in self._strokes]
        plants = [self.plant(each) for each in new]
        voltages = np.array([self.voltages(each.u) for each in new]).reshape(-1, 2)
        runs = strokes(plants, voltages, INTERVAL, LONGEST_STROKE, self._threads)
        self._strokes |= dict(zip(new, map(Stroke, new, runs, plants), strict=True))
        return [self._strokes[each] for each in wanted]

    def captions(self, law: str = 'revised_lugre_dwell') -> list[Stroke]:
        """Return the strokes of Fig. 4-6 of its cylinders under a friction law."""
        return self.perform_all(replace(CAPTIONS[name], law=law) for name in self.cylinders)

    def voltages(self, u: float) -> tuple[float, float]:
        """Return the valve voltages [V] of a printed command u [V]."""
        return valve_voltages(self.conditions.command * u)

    def plant(self, experiment: Experiment) -> Plant:
        """Return the plant of an experiment, at rest at its start."""
        model = self.reading.model(experiment.cylinder)
        above = BAR * (experiment.supply - CAPTION_SUPPLY)
        start = self.conditions.start if experiment.start is None else experiment.start
        changes = {
            'supply_pressure': self.conditions.supply * (model.operation.supply_pressure + above),
            'load_mass': experiment.load_mass,
        }
        if start is not None:
            changes['initial_position'] = start * model.cylinder.stroke
        friction = model.friction._replace(model=FRICTION_MODELS.index(experiment.law))
        operation = model.operation._replace(**changes)
        return Plant(model._replace(friction=friction, operation=operation), tolerance=TOLERANCE)


@cache
def shipped(cylinder: str) -> Model:
    """Return the model of a shipped cylinder."""
    return load_configuration(cylinder).model
