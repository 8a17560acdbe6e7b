"""The shapes of excitations: a level as a function of time, each with its parameters."""

import bisect
import math
from collections.abc import Iterator
from itertools import accumulate
from typing import Annotated, NamedTuple

from pneu_rig_ros.model.quantity import Quantity, QuantityList

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
        if not self.levels:
            return 0.0
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
        return self.drive if bisect.bisect_right(list(self._edges()), time) % 2 else self.rest

    def _edges(self) -> Iterator[float]:
        """Yield the times at which rest and move take turns [s]."""
        return accumulate(part for dwell in self.dwells for part in (dwell, self.move))


Shape = Step | Ramp | Staircase | SineSweep | DwellLadder

SHAPES: dict[str, type[Shape]] = {
    'step': Step,
    'ramp': Ramp,
    'staircase': Staircase,
    'sine_sweep': SineSweep,
    'dwell_ladder': DwellLadder,
}
"""Name in a file -> shape."""
