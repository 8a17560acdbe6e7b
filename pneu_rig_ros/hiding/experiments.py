"""
The experiments of the demonstration: three that are fitted, one that judges.

Together they hold slow outstrokes that stick and slip, rests with the valves shut, faster strokes
both ways, both ends of the stroke, and several supply pressures, loads and places to start from.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import yaml

from pneu_rig_ros.report.writing import write_whole

CYLINDER = 'cylinder_1'
"""Whose commands these are: where it sticks and slips, it does so for seconds."""

HOLD = 0.5
"""Time for which each level is held [s]."""


class Experiment(NamedTuple):
    """
    A run under its own conditions.

    :param name: of the bag
    :param supply_pressure: absolute [Pa]
    :param load_mass: [kg]
    :param initial_position: [m]
    :param rest_time: before the run [s]
    :param levels: commands u [V], each held for :data:`HOLD`
    """

    name: str
    supply_pressure: float
    load_mass: float
    initial_position: float
    rest_time: float
    levels: tuple[float, ...]

    @property
    def duration(self) -> float:
        """Length [s]."""
        return HOLD * len(self.levels)

    @property
    def setup(self) -> dict[str, float]:
        """Parameters of the plant that make its conditions."""
        return {
            'supply_pressure': self.supply_pressure,
            'load_mass': self.load_mass,
            'initial_position': self.initial_position,
            'rest_time': self.rest_time,
        }

    def write_profile(self, path: Path) -> Path:
        """Write the command as a profile of the excitation node."""
        levels = [f'{level!r} V' for level in self.levels]
        data = {'drives': 'u', 'shape': 'staircase', 'levels': levels, 'hold': f'{HOLD!r} s'}
        return write_whole(path, yaml.safe_dump(data, sort_keys=False))


def _levels(*parts: tuple[float, float]) -> tuple[float, ...]:
    """Return the levels of parts, each a duration [s] and a command [V]."""
    return tuple(level for time, level in parts for _ in range(round(time / HOLD)))


SHUT = 0.0
FITTED = (
    Experiment('creeping', 5e5, 0.2, 0.0, 1200.0, _levels(  # sticks and slips as in the paper
        (0.5, SHUT), (4.0, 0.29), (1.0, SHUT), (2.0, 0.33), (0.5, SHUT), (2.0, -0.35),
    )),
    Experiment('there_and_back', 4e5, 2.0, 0.15, 60.0, _levels(
        (0.5, SHUT), (2.5, -0.34), (1.0, SHUT), (2.0, 0.6), (1.5, SHUT), (2.0, -0.6),
    )),
    Experiment('to_the_end', 7e5, 5.3, 0.22, 600.0, _levels(  # onto the outer stop and back
        (0.5, SHUT), (2.5, 1.8), (2.0, SHUT), (2.5, -0.6), (0.5, SHUT), (1.5, -0.35),
    )),
)  # fmt: skip
JUDGING = Experiment('held_out', 6e5, 1.0, 0.05, 300.0, _levels(
    (0.5, SHUT), (3.0, 0.3), (1.5, SHUT), (1.5, 0.45), (1.0, SHUT), (2.0, -0.4),
))  # fmt: skip
