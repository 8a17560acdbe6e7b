"""Excitations from files: what is driven, the valve command or the position, and its shape."""

import bisect
import math
from dataclasses import dataclass, replace
from itertools import accumulate
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.quantity import (
    Quantity,
    QuantityList,
    Specification,
    read_section,
    specifications,
    unknown,
)
from pneu_rig_ros.rig.yaml_file import locate, read_yaml

LEVEL = Quantity('V', -2.5, 2.5, 'level')
"""What a level is in the shapes below; ``excitation`` puts metres in its place for positions."""

_SPAN = Quantity('s', 0.0, 86_400.0, 'length of a part')
_LENGTH = Quantity('s', 1e-3, 86_400.0, 'length of a part')
_FREQUENCY = Quantity('Hz', 1e-4, 400.0, 'frequency')
_MOST_PARTS = 1000


class Step(NamedTuple):
    """One level, then another."""

    before: Annotated[float, LEVEL]
    after: Annotated[float, LEVEL]
    delay: Annotated[float, _SPAN]
    hold: Annotated[float, _SPAN]

    @property
    def duration(self) -> float:
        """Length [s]."""
        return self.delay + self.hold

    def level(self, time: float) -> float:
        """Return the level at a time since the start [s]."""
        return self.before if time < self.delay else self.after


class Ramp(NamedTuple):
    """From one level to another at a constant rate; both are held."""

    start: Annotated[float, LEVEL]
    end: Annotated[float, LEVEL]
    delay: Annotated[float, _SPAN]
    rise: Annotated[float, _LENGTH]
    hold: Annotated[float, _SPAN]

    @property
    def duration(self) -> float:
        """Length [s]."""
        return self.delay + self.rise + self.hold

    def level(self, time: float) -> float:
        """Return the level at a time since the start [s]."""
        share = min(max((time - self.delay) / self.rise, 0.0), 1.0)
        return self.start + share * (self.end - self.start)


class Staircase(NamedTuple):
    """Levels one after the other, each held for the same time."""

    levels: Annotated[tuple[float, ...], QuantityList(LEVEL, _MOST_PARTS)]
    hold: Annotated[float, _LENGTH]

    @property
    def duration(self) -> float:
        """Length [s]."""
        return len(self.levels) * self.hold

    def level(self, time: float) -> float:
        """Return the level at a time since the start [s]."""
        return self.levels[min(max(int(time / self.hold), 0), len(self.levels) - 1)]


class SineSweep(NamedTuple):
    """A sine whose frequency grows exponentially, the same number of periods in each octave."""

    offset: Annotated[float, LEVEL]
    amplitude: Annotated[float, LEVEL]
    start_frequency: Annotated[float, _FREQUENCY]
    end_frequency: Annotated[float, _FREQUENCY]
    sweep: Annotated[float, _LENGTH]

    @property
    def duration(self) -> float:
        """Length [s]."""
        return self.sweep

    def level(self, time: float) -> float:
        """Return the level at a time since the start [s]."""
        growth = math.log(self.end_frequency / self.start_frequency) / self.sweep
        # the integral of the frequency, expm1(g t)/g, whose limit for a constant one is t
        periods = self.start_frequency * (math.expm1(growth * time) / growth if growth else time)
        return self.offset + self.amplitude * math.sin(2.0 * math.pi * periods)


class DwellLadder(NamedTuple):
    """Moves of equal length with rests of growing length between them, for Eq. 16."""

    rest: Annotated[float, LEVEL]
    drive: Annotated[float, LEVEL]
    move: Annotated[float, _LENGTH]
    dwells: Annotated[tuple[float, ...], QuantityList(_LENGTH, _MOST_PARTS)]

    @property
    def duration(self) -> float:
        """Length [s]."""
        return sum(self.dwells) + len(self.dwells) * self.move

    def level(self, time: float) -> float:
        """Return the level at a time since the start [s]: first a rest, then a move, ..."""
        edges = accumulate(part for dwell in self.dwells for part in (dwell, self.move))
        return self.drive if bisect.bisect_right(list(edges), time) % 2 else self.rest


Shape = Step | Ramp | Staircase | SineSweep | DwellLadder

SHAPES: dict[str, type[Shape]] = {
    'step': Step,
    'ramp': Ramp,
    'staircase': Staircase,
    'sine_sweep': SineSweep,
    'dwell_ladder': DwellLadder,
}
"""Name in a file -> shape."""

COMMAND, REFERENCE = 'u', 'reference'
LEVELS = {COMMAND: LEVEL, REFERENCE: Quantity('m', 0.0, 10.0, 'position reference')}
"""Topic that is driven -> what its level is."""


@dataclass(frozen=True)
class Excitation:
    """A level over time of the topic that it drives, 'u' [V] or 'reference' [m]."""

    name: str
    drives: str
    shape: Shape

    @property
    def duration(self) -> float:
        """Length [s]."""
        return self.shape.duration

    def level(self, time: float) -> float:
        """
        Return the level at a time since the start [s], in V or m.

        Afterwards the valves are shut (u = 0), and a position is kept.
        """
        if time < self.duration:
            return self.shape.level(time)
        return 0.0 if self.drives == COMMAND else self.shape.level(self.duration)


def load_excitation(source: str | Path) -> Excitation:
    """Read a shipped excitation by its name, or a YAML file; RigError if anything is wrong."""
    path = locate(source, 'excitation', 'excitations/*.yaml')
    data = read_yaml(path)
    drives = _name(data, 'drives', list(LEVELS), path)
    kind = _name(data, 'shape', list(SHAPES), path)
    values = {key: value for key, value in data.items() if key not in ('drives', 'shape')}
    shape = read_section(_with_level(SHAPES[kind], LEVELS[drives]), values, str(path))
    excitation = Excitation(path.stem, drives, shape)
    if not excitation.duration > 0.0:
        raise RigError(f'{path}: lasts 0 s, must be longer')
    return excitation


def _name(data: dict[str, Any], key: str, allowed: list[str], path: Path) -> str:
    if key not in data:
        raise RigError(f'{path}: missing {key}, one of {", ".join(allowed)}')
    if data[key] not in allowed:
        raise RigError(f'{path}: {key}: {unknown(str(data[key]), allowed)}')
    return str(data[key])


def _with_level(shape: type[Shape], level: Quantity) -> type[Shape]:
    """Return the shape with another unit and range of its levels."""

    def of(specification: Specification) -> Specification:
        if isinstance(specification, QuantityList) and specification.item is LEVEL:
            return replace(specification, item=level)
        return level if specification is LEVEL else specification

    hints = {key: Annotated[Any, of(spec)] for key, spec in specifications(shape).items()}
    return type(shape.__name__, (shape,), {'__annotations__': hints})
