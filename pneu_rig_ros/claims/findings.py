"""What a finding, a statement and a row are, and margins."""

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.claims.experiments import Laboratory

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
    A statement of the paper.

    :param number: from 1
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
