"""
What nobody has named yet: a sparse term that describes the gap, and can be added and simulated.

It says where the gap is and what would shrink it, not why.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pneu_rig_ros.executor import Executor
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.fitting import Explanation
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode
from pneu_rig_ros.gap.scoring import Scored, Setting
from pneu_rig_ros.gap.shrink import above_floor
from pneu_rig_ros.gap.terms import growing
from pneu_rig_ros.gap.where import disagreements
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.effect import READING_BALANCES

LEAST_GAIN = 0.9
"""More terms that leave more than this share of the cost are left out [-]."""
SHRUNK = 0.95
"""What leaves more than this share of the gap may owe it to the draw of the noise floors [-]."""


@dataclass(frozen=True)
class Description:
    """
    A description of what is not known.

    :param balance, regime, unit: where it shows
    :param term: formula for a person, '' where no simple term shrinks the gap
    :param gap_left: share of the gap above the noise that is left on runs not fitted [-]
    :param hypothesis: with the description as an effect
    :param explanation: what was fitted
    """

    balance: str
    regime: str
    unit: str
    term: str
    gap_left: float
    hypothesis: Hypothesis
    explanation: Explanation

    def to_dict(self) -> dict[str, Any]:
        """Return what diagnosis.json says of it."""
        return {'balance': self.balance, 'regime': self.regime, 'unit': self.unit,
                'term': self.term, 'gap_left': self.gap_left}  # fmt: skip


def describe(
    known: Hypothesis, fitted: Evidence, held: Evidence, mode: Mode, limit: float,
    executor: Executor,
) -> Description:  # fmt: skip
    """
    Return the description that shrinks the gap of a prediction most.

    The sensors are blamed only where their errors leave nothing significant: a share of any gap
    can be put on them. One that shrinks nothing on runs not fitted is left out.

    :param limit: cost below which nothing significant is left [-]
    """
    setting = Setting(known, fitted, held, (mode,))
    grown = growing(setting, limit, executor)
    tried = [one for one in grown if not _of_sensors(one) or one.worst < limit]
    best, left = shrinking(tried, setting, limit)
    where = _place(best or sparsest(tried, limit), known, fitted, mode)
    if best is None:
        return Description(*where, '', left, known, Explanation())
    explanation = best.fit.explanation
    return Description(*where, formula(explanation), left, explanation.apply(known), explanation)


def shrinking(
    tried: Sequence[Scored], setting: Setting, limit: float
) -> tuple[Scored | None, float]:
    """
    Return the one to be preferred of those that make the gap smaller on runs not fitted.

    And the share of the gap above the noise that it leaves there; 1 for none.
    """
    remaining = list(tried)
    while remaining:
        one = sparsest(remaining, limit)
        improved = one.fit.explanation.apply(setting.given)
        before, after = above_floor(setting.given, improved, setting.held)
        if after < SHRUNK * before:
            return one, after / before
        remaining.remove(one)
    return None, 1.0


def sparsest(tried: Sequence[Scored], limit: float) -> Scored:
    """Return the one of the fewest terms that closes the gap, or leaves hardly more than any."""
    least = min(one.worst for one in tried)
    good = [one for one in tried if one.worst <= max(limit, least / LEAST_GAIN)]
    return min(good, key=lambda one: (len(one.fit.explanation.coordinates), one.worst))


def _place(best: Scored, known: Hypothesis, fitted: Evidence, mode: Mode) -> tuple[str, str, str]:
    """Return the balance that a description acts on, the regime where it shows, and the unit."""
    where = [one for one in disagreements(known, fitted) if _shows(one.balance, mode)]
    regime = where[0].regime if where else 'sliding'
    if _of_sensors(best):
        part = best.fit.explanation.parts[0]
        return part.balance, regime, part.coordinates[0].quantity.unit
    if where:
        return where[0].balance, regime, where[0].unit
    return _default(mode)


def _of_sensors(one: Scored) -> bool:
    """Return whether a description is of errors of the sensors."""
    return library.load(one.fit.explanation.parts[0].name).balance in READING_BALANCES


def _shows(balance: str, mode: Mode) -> bool:
    return balance.startswith('gas') == (mode is Mode.CHAMBERS)


def _default(mode: Mode) -> tuple[str, str, str]:
    if mode is Mode.CHAMBERS:
        return 'gas mass 1', 'sliding out', 'kg/s'
    return 'force', 'breakaway', 'N'


def formula(explanation: Explanation) -> str:
    """Return a description's effect and its terms for a person."""
    pairs = zip(explanation.coordinates, explanation.values[0], strict=True)
    texts = [f'{value:+.3g} {c.quantity.unit} {c.name}' for c, value in pairs]
    return f'{explanation.name}: {" ".join(texts).removeprefix("+")}'
