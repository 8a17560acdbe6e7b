"""What a finding, a statement and a row are, what is measured on a stroke, and margins."""

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.claims.experiments import INTERVAL, Laboratory, Stroke

VISIBLE_CREEP = 0.5e-3
"""
A sticking phase with more travel than this creeps [m].

Seven steps of the position sensor; a bristle of 1e5 N/m bends by 0.2 mm under F_smax.
"""
LONGEST_LINE = 8
"""Values in a line of text; further ones are left to the page."""


@dataclass(frozen=True)
class Finding:
    """
    One thing that a statement says.

    :param says: what
    :param measured: the numbers measured
    :param margin: how far they are inside (positive) or outside of what is said, as a share of
        it [-]; NaN when there is nothing to measure
    """

    says: str
    measured: str
    margin: float

    @property
    def holds(self) -> bool:
        """Whether it is so."""
        return bool(self.margin >= 0.0)

    @property
    def clipped_margin(self) -> float:
        """Margin within -1 to 1, -1 when there is nothing to measure [-]."""
        return float(np.clip(self.margin, -1.0, 1.0)) if self.margin == self.margin else -1.0


@dataclass(frozen=True)
class Statement:
    """
    One statement of the paper.

    :param number: of the statement, from 1
    :param text: what the paper says, in a sentence
    :param measure: carries out the experiments and yields the findings
    """

    number: int
    text: str
    measure: Callable[[Laboratory], Iterable[Finding]]


@dataclass(frozen=True)
class Row:
    """A statement measured under one reading."""

    statement: Statement
    findings: tuple[Finding, ...]

    @property
    def holds(self) -> bool:
        """Whether all findings hold."""
        return all(finding.holds for finding in self.findings)

    @property
    def tightest(self) -> Finding:
        """The finding with the least margin."""
        return min(self.findings, key=lambda finding: finding.clipped_margin)

    @property
    def measured(self) -> str:
        """The finding with the least margin, or all that fail, in lines."""
        failed = [f'NOT {f.says}: {f.measured}' for f in self.findings if not f.holds]
        return '\n'.join(failed) or f'{self.tightest.says}: {self.tightest.measured}'

    def to_dict(self, shares: Mapping[int, float]) -> dict[str, Any]:
        """Return plain data for JSON; shares as of ``markdown``, None where not measured."""
        return {
            'statement': self.statement.number,
            'expected': self.statement.text,
            'measured': [
                {'finding': finding.says, 'measured': finding.measured, 'holds': finding.holds}
                for finding in self.findings
            ],
            'holds': self.holds,
            'neighbours': shares.get(self.statement.number),
        }


def markdown(rows: Sequence[Row], shares: Mapping[int, float] | None = None) -> str:
    """
    Return a table with verdict and tightest finding of each statement.

    :param rows: statements, measured
    :param shares: number of a statement -> share of the neighbours under which it holds [-]
    """
    head, rule = (' neighbours |', ' --- |') if shares else ('', '')
    lines = [
        f'| | the paper says | holds |{head} tightest finding: measured |',
        f'| --- | --- | --- |{rule} --- |',
    ]
    for row in rows:
        number, tightest = row.statement.number, row.tightest
        verdict = 'yes' if row.holds else 'no'
        share = f' {shares[number]:.0%} |' if shares else ''
        finding = f'{tightest.says}: {tightest.measured}'.replace('cylinder_', 'cylinder ')
        lines.append(f'| {number} | {row.statement.text} | {verdict} |{share} {finding} |')
    return '\n'.join(lines)


def middle(values: Floats) -> float:
    """Return the median, NaN of nothing."""
    return float(np.median(values)) if len(values) else np.nan


def dwells(stroke: Stroke) -> Floats:
    """Return the dwell times between slips [s]: all but the rest before the first."""
    return stroke.column('dwell', 1)


def slips(stroke: Stroke) -> Floats:
    """Return the slip lengths [m] but for the first, from rest, and the last, into the end."""
    return stroke.column('slip', 1)[:-1]


def median_dwells(strokes: Sequence[Stroke]) -> list[float]:
    """Return the median of the dwell times between slips of each stroke [s]."""
    return [middle(dwells(stroke)) for stroke in strokes]


def median_slips(strokes: Sequence[Stroke]) -> list[float]:
    """Return the median slip length of each stroke [mm]."""
    return [1e3 * middle(slips(stroke)) for stroke in strokes]


def rest_share(stroke: Stroke, to_end: bool = False) -> float:
    """Return the share at rest of the time from the first slip to the last, or to the end [-]."""
    breakaways = stroke.column('breakaway_time')
    if len(breakaways) < 2:
        return 0.0
    last = stroke.run.time[-1] if to_end else breakaways[-1]
    return float(dwells(stroke).sum() / (last - breakaways[0]))


def stick_slip_reach(stroke: Stroke) -> float:
    """Return the share of the way covered at which the last slip begins [-]."""
    if not stroke.cycles:
        return 0.0
    last = np.interp(stroke.cycles[-1].breakaway_time, stroke.run.time, stroke.run.position)
    return float((last - stroke.start) / (stroke.run.position[-1] - stroke.start))


def creeping_share(stroke: Stroke) -> float:
    """Return the share of the sticking phases with visible creep [-]."""
    creep = stroke.column('creep')
    return float(np.mean(creep > VISIBLE_CREEP)) if len(creep) else np.nan


def pressure_peaks(stroke: Stroke) -> tuple[Floats, Floats]:
    """Return p1 above the atmosphere [Pa]: at n breakaways, and n - 1 lowest between them."""
    begins = np.rint(stroke.column('breakaway_time') / INTERVAL).astype(np.intp)
    pressure = stroke.run.pressure_1 - stroke.plant.model.gas.atmospheric_pressure
    lows = [pressure[a:b].min() for a, b in itertools.pairwise(begins)]
    return pressure[begins], np.array(lows)


def pressure_drops(stroke: Stroke) -> float:
    """Return the share of slips in which p1 falls by a tenth of what it was above p_atm [-]."""
    peaks, lows = pressure_peaks(stroke)
    return float(np.mean(peaks[:-1] - lows > 0.1 * peaks[:-1])) if len(lows) else 0.0


def pressure_rise(stroke: Stroke) -> float:
    """Return the median rise of p1 from its lowest value to the next breakaway [Pa]."""
    peaks, lows = pressure_peaks(stroke)
    return middle(peaks[1:] - lows)


def gradual(values: Floats) -> float:
    """Return the magnitude of the correlation of values with their number [-], 0 for few."""
    if len(values) < 4 or np.ptp(values) == 0.0:
        return 0.0
    return float(abs(np.corrcoef(np.arange(len(values)), values)[0, 1]))


def numbers(values: Sequence[float] | Floats, pattern: str = '.2f') -> str:
    """Return the first values in a line, a dash for each that is none."""
    texts = ['-' if value != value else format(value, pattern) for value in values[:LONGEST_LINE]]
    return ', '.join([*texts, '...'] if len(values) > LONGEST_LINE else texts)


def at_least(value: float, bound: float) -> float:
    """Return by which share of the bound a value is above it [-]."""
    return float(value / bound) - 1.0 if bound else np.nan


def at_most(value: float, bound: float) -> float:
    """Return by which share of the bound a value is below it [-]."""
    return -at_least(value, bound)


def require_at_least(says: str, value: float, bound: float, pattern: str = '.0%') -> Finding:
    """Return the finding that a single number is at least a bound."""
    return Finding(says, numbers([value], pattern), at_least(value, bound))


def falls(values: Floats) -> float:
    """Return the fall of a straight line through three or more values, by their mean [-]."""
    if len(values) < 3 or not np.any(values):
        return -1.0
    slope = float(np.polyfit(np.arange(len(values)), values, 1)[0])
    return -slope * (len(values) - 1) / float(np.mean(values))


def rises_throughout(values: Sequence[float] | Floats) -> float:
    """Return the least relative rise from a value to the next [-]."""
    return float(np.min([at_least(b, a) for a, b in itertools.pairwise(values)]))


def falls_throughout(values: Sequence[float]) -> float:
    """Return the least relative fall from a value to the next [-]."""
    return float(np.min([at_most(b, a) for a, b in itertools.pairwise(values)]))


def grows(values: Sequence[float]) -> float:
    """Return the rise of a straight line through the finite values, see :func:`falls` [-]."""
    finite = np.array([value for value in values if np.isfinite(value)])
    return -falls(finite) if len(finite) >= 3 else -1.0


def unchanged(values: Sequence[float], share: float) -> float:
    """Return how far the largest is within a share of the smallest, as a part of the share."""
    if not (np.all(np.isfinite(values)) and min(values) > 0.0):
        return -1.0
    return 1.0 - (max(values) / min(values) - 1.0) / share
