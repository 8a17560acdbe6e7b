"""What a statement, a finding and a row of the table are, and how trends are judged."""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pneu_rig_ros.claims.experiments import Laboratory, Stroke


@dataclass(frozen=True)
class Finding:
    """One thing that a statement says: what, the number measured, and whether it is so."""

    says: str
    measured: str
    holds: bool


@dataclass(frozen=True)
class Statement:
    """
    One statement of the paper.

    :param number: 1-10, as in the notes on the model
    :param text: what the paper says, in a sentence
    :param measure: carries out the experiments and returns the findings
    """

    number: int
    text: str
    measure: Callable[[Laboratory], Sequence[Finding]]


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
    def share(self) -> float:
        """Share of the findings that hold [-]."""
        return sum(finding.holds for finding in self.findings) / len(self.findings)


def numbers(values: Sequence[float] | np.ndarray[Any, Any], pattern: str = '.2f') -> str:
    """Return values in a line, a dash for each that is none."""
    return ', '.join('-' if value != value else format(value, pattern) for value in values)


def middle(values: np.ndarray[Any, Any]) -> float:
    """Return the median, NaN of nothing."""
    return float(np.median(values)) if len(values) else np.nan


def falls(values: np.ndarray[Any, Any]) -> bool:
    """Return whether a straight line through at least three values goes down."""
    return len(values) >= 3 and float(np.polyfit(np.arange(len(values)), values, 1)[0]) < 0.0


def rises_throughout(values: Sequence[float], slack: float = 0.0) -> bool:
    """Return whether each value is above the one before, but for a share of slack."""
    return all(b > a * (1.0 - slack) for a, b in itertools.pairwise(values))


def falls_throughout(values: Sequence[float], slack: float = 0.0) -> bool:
    """Return whether each value is below the one before, but for a share of slack."""
    return all(b < a * (1.0 + slack) for a, b in itertools.pairwise(values))


def dwells(stroke: Stroke) -> np.ndarray[Any, Any]:
    """Return the dwell times between slips [s]: all but the rest before the first."""
    return stroke.column('dwell', 1)


def slips(stroke: Stroke) -> np.ndarray[Any, Any]:
    """Return the slip lengths [m] but for the first, from rest, and the last, into the end."""
    return stroke.column('slip', 1)[:-1]


def grows(values: Sequence[float]) -> bool:
    """Return whether the last finite value is above the first of at least two."""
    finite = [value for value in values if np.isfinite(value)]
    return len(finite) >= 2 and finite[-1] > finite[0]


def unchanged(values: Sequence[float], share: float) -> bool:
    """Return whether all values are finite and the largest is within a share of the smallest."""
    return bool(np.all(np.isfinite(values))) and max(values) <= (1.0 + share) * min(values)
