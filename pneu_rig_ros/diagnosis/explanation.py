"""An explanation: candidates with values, as a fit sees them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.diagnosis.candidates import CALIBRATION, Candidate, Coordinate
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Explanation:
    """
    Candidates with values.

    :param parts: the candidates
    :param values: of each one's coordinates [SI]
    """

    parts: tuple[Candidate, ...] = ()
    values: tuple[tuple[float, ...], ...] = ()

    @property
    def name(self) -> str:
        """The names of all parts."""
        return ' + '.join(part.name for part in self.parts)

    @property
    def causes(self) -> list[str]:
        """The names of all parts but the gains of the sensors, which are fitted along."""
        return [part.name for part in self.parts if part.name != CALIBRATION]

    def apply(self, given: Hypothesis) -> Hypothesis:
        """Return the given hypothesis with all explanations."""
        for part, values in zip(self.parts, self.values, strict=True):
            given = part.apply(given, values)
        return given

    def with_part(self, part: Candidate, values: Sequence[float]) -> Explanation:
        """Return the explanation with one more part."""
        return Explanation((*self.parts, part), (*self.values, tuple(values)))

    def without(self, index: int) -> Explanation:
        """Return the explanation without one of its parts."""
        keep = [i for i in range(len(self.parts)) if i != index]
        return Explanation(tuple(self.parts[i] for i in keep), tuple(self.values[i] for i in keep))

    def joined(self, other: Explanation) -> Explanation:
        """Return the explanation with all parts of another one."""
        return Explanation(self.parts + other.parts, self.values + other.values)

    @property
    def coordinates(self) -> list[Coordinate]:
        """All coordinates in a row."""
        return [coordinate for part in self.parts for coordinate in part.coordinates]

    @property
    def theta(self) -> Floats:
        """What the fit sees of all values in a row."""
        flat = [value for values in self.values for value in values]
        pairs = zip(self.coordinates, flat, strict=True)
        return np.array([coordinate.to_internal(value) for coordinate, value in pairs])

    def with_theta(self, seen: Floats) -> Explanation:
        """Return the explanation with other values, as the fit sees them."""
        pairs = zip(self.coordinates, seen, strict=True)
        flat = iter([coordinate.from_internal(float(value)) for coordinate, value in pairs])
        values = tuple(tuple(next(flat) for _ in part.coordinates) for part in self.parts)
        return Explanation(self.parts, values)
