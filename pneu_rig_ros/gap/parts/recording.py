"""A measured run of a part: what signals there are, on a uniform grid, with their noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.gap.bags import run_name
from pneu_rig_ros.gap.noise import reading_noise
from pneu_rig_ros.gap.parts.part import CHAMBERS, FRICTION, VALVES
from pneu_rig_ros.records.conditions import conditions_beside, conditions_of, with_zero
from pneu_rig_ros.records.table import read_table, uniform

Floats = NDArray[np.float64]

MOST_SAMPLES = {CHAMBERS: 1000, FRICTION: 4000, VALVES: 20000}
"""Kind of part -> samples of a run that are used, evenly chosen."""
SMOOTHED = 7
"""Samples of the cubic fits that smooth the position."""
BACK, LEAST_BACK = 8.0, 5e-5
"""A way back counts from so many noises of the position on [-], and from this on [m]."""
REST_SPEED = 1e-3
"""A piston slower than this rests [m/s]."""
PRESLIDING = 1e-3
"""Way after a reversal within which the bristles bend [m]."""
REGIMES = ('dwell', 'presliding', 'sliding out', 'sliding in')
DWELL, PRESLIDE, OUT, IN = range(4)
LEAST_SHARE = 0.02
"""Share of the samples below which a regime has no say of its own [-]."""


@dataclass(frozen=True)
class Recording:
    """
    A measured run of a part.

    :param name: of the file
    :param interval: between samples [s]
    :param signals: name -> values, SI units, absolute pressures, shape (n,) each
    :param noise: name -> standard deviation of a reading
    :param conditions: that are known, see ``records.conditions`` [SI]
    """

    name: str
    interval: float
    signals: Mapping[str, Floats]
    noise: Mapping[str, float]
    conditions: Mapping[str, float] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Floats:
        """Return a signal, shape (n,)."""
        return self.signals[name]

    def __contains__(self, name: object) -> bool:
        """Return whether there is such a signal."""
        return name in self.signals

    @property
    def size(self) -> int:
        """Number of samples."""
        return next(iter(self.signals.values())).size

    @cached_property
    def position(self) -> Floats:
        """Smoothed position [m]; at rest at 0 where none was measured."""
        if 'position' not in self:
            return np.zeros(self.size)
        smooth = savgol_filter(self['position'], SMOOTHED, 3)
        return without_jumps_back(smooth, max(BACK * self.noise['position'], LEAST_BACK))

    @cached_property
    def velocity(self) -> Floats:
        """Velocity [m/s] from each sample to the next, shape (n - 1,)."""
        velocity: Floats = np.diff(self.position) / self.interval
        return velocity

    def pressures(self, outside: float) -> Floats:
        """Return p1, p2 [Pa], shape (n, 2); ``outside`` where one was not measured."""
        unmeasured = np.full(self.size, outside)
        columns = (self.signals.get(f'pressure_{i}', unmeasured) for i in (1, 2))
        return np.column_stack(list(columns))

    @cached_property
    def regimes(self) -> NDArray[np.int8]:
        """Regime of every sample but the first, an index of ``REGIMES``, shape (n - 1,)."""
        speed = np.abs(self.velocity)
        out = self.velocity > 0.0
        regimes = np.where(out, OUT, IN)
        moving = np.flatnonzero(speed >= REST_SPEED)
        turns = moving[1:][out[moving[1:]] != out[moving[:-1]]]
        way = np.concatenate([[0.0], np.cumsum(speed[:-1])]) * self.interval
        for turn in turns:
            regimes[turn:][way[turn:] < way[turn] + PRESLIDING] = PRESLIDE
        regimes[(speed < REST_SPEED) & (regimes != PRESLIDE)] = DWELL
        kinds: NDArray[np.int8] = regimes.astype(np.int8)
        return kinds

    @cached_property
    def weights(self) -> Floats:
        """Weight of every sample but the first, the same for each regime, shape (n - 1,)."""
        counts = np.bincount(self.regimes, minlength=len(REGIMES))
        least = LEAST_SHARE * self.regimes.size
        each = np.where(counts >= least, 1.0 / np.maximum(counts, 1), 1.0 / self.regimes.size)
        weights: Floats = each[self.regimes]
        weights /= weights.sum()
        return weights


def without_jumps_back(position: Floats, least: float) -> Floats:
    """
    Return a position that does not go back where it went back by less than ``least`` [m].

    Stamps that jitter look like short reversals, which the bristles of a seal would answer.
    """
    extremes, sign = [0], 0
    for index, value in enumerate(position):
        way = float(value - position[extremes[-1]])
        if sign == 0 and abs(way) > least:
            sign = 1 if way > 0.0 else -1
            extremes.append(index)
        elif sign * way > 0.0:
            extremes[-1] = index
        elif -sign * way > least:
            sign = -sign
            extremes.append(index)
    cleaned: Floats = position.copy()
    for first, last in zip(extremes, [*extremes[1:], position.size - 1], strict=True):
        stretch = cleaned[first : last + 1]
        rising = stretch[-1] >= stretch[0]
        stretch[:] = (np.maximum if rising else np.minimum).accumulate(stretch)
    return cleaned


def read_recording(path: Path, mapping: Path | str | None, kind: str, outside: float) -> Recording:
    """
    Read a run from a text table or a bag, with its conditions.

    :param mapping: where the signals are, and their units; a bag of the project needs none
    :param outside: zero of gauge pressures [Pa], where the conditions do not say
    :raises RigError: when the part's signals are not all there
    """
    outside = conditions_beside(path).get('atmospheric_pressure', outside)
    table = uniform(read_table(path, mapping, outside))
    run = recording(run_name(path), table.interval, table.signals, kind)
    known = with_zero(conditions_of(path, table), table.atmospheric_pressure)
    return replace(run, conditions=known)


def recording(name: str, interval: float, signals: Mapping[str, Floats], kind: str) -> Recording:
    """Return a run of signals [SI]; RigError when the part's are not all there."""
    known = dict(signals)
    if 'u' in known and 'voltage_1' not in known:
        known['voltage_1'], known['voltage_2'] = 2.5 + known['u'], 2.5 - known['u']
    if 'force' in known and 'friction' in known:
        del known['friction']
    for choice in WANTED[kind]:
        if not any(one in known for one in choice):
            raise RigError(f'{name}: no {" or ".join(choice)}, needed for {kind}')
    noise = {key: reading_noise(values, rounding(values)) for key, values in known.items()}
    step = -(-next(iter(known.values())).size // MOST_SAMPLES[kind])
    thinned = {key: np.ascontiguousarray(values[::step]) for key, values in known.items()}
    return Recording(name, interval * step, thinned, noise)


def rounding(values: Floats) -> float:
    """Return the standard deviation of what a converter rounds off, by its smallest step."""
    steps = np.abs(np.diff(values))
    return float(steps[steps > 0.0].min(initial=np.inf) / np.sqrt(12.0)) if steps.any() else 0.0


_PRESSURES = ('pressure_1', 'pressure_2')
WANTED: dict[str, Sequence[Sequence[str]]] = {
    CHAMBERS: (('position',), _PRESSURES),
    FRICTION: (('position',), _PRESSURES, ('force', 'friction')),
    VALVES: (_PRESSURES, ('u', 'voltage_1', 'voltage_2')),
}
"""Kind of part -> signals, of each group at least one."""
COMPARED = {CHAMBERS: _PRESSURES, FRICTION: ('force', 'friction'), VALVES: _PRESSURES}
"""Kind of part -> signals whose noise tells what a gap is."""
