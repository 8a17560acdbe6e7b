"""The verdict, of a system and of each of its balances, and how probable it is that it is true."""

from collections.abc import Sequence

import numpy as np

from pneu_rig_ros.diagnosis.causes.candidates import CALIBRATION, FORCE, Candidate, Explanation
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.balances import BALANCES
from pneu_rig_ros.diagnosis.residuals.cycles import Cycles
from pneu_rig_ros.diagnosis.residuals.dataset import LARGEST, Dataset, by_balance, loss
from pneu_rig_ros.diagnosis.search.scoring import DECISIVE

CONSISTENT, UNCALIBRATED, CONDITIONS = 'consistent', 'uncalibrated', 'conditions'
PARAMETER, EFFECT, UNKNOWN = 'parameter', 'effect', 'unknown'
"""Verdicts."""
TRUE_ANSWERS = {
    ('conditions', False): (37, 38),
    ('consistent', False): (12, 14),
    ('effect', False): (100, 132),
    ('effect', True): (7, 7),
    ('parameter', False): (0, 10),
    ('uncalibrated', True): (14, 15),
    ('unknown', False): (7, 33),
}
"""
Verdict, and whether sensors are known to their class only -> true answers and all answers, of
seeds 77 to 86 in ``docs/blind_foreign.md``: earlier ones are of a method that named less.
"""


def of_parts(parts: Sequence[Candidate]) -> str:
    """Return the verdict on what is explained by some causes."""
    causes = [part for part in parts if part.name != CALIBRATION]
    if not causes:
        return UNCALIBRATED if parts else CONSISTENT
    if any(part.is_effect for part in causes):
        return EFFECT
    return PARAMETER if any(part.is_parameter for part in causes) else CONDITIONS


def of_balances(
    explanation: Explanation, dataset: Dataset, cycles: Cycles | None = None
) -> dict[str, str]:
    """
    Return balance -> the verdict by the causes that its residuals show.

    They show a cause without which they are decisively less likely. Another form of an effect is
    no cause of its own.

    :param cycles: simulated cycles that show causes of friction too, if simulation was used
    """
    all_causes = explanation.hypothesis
    with_all = _losses(all_causes, dataset)
    shown: dict[str, list[Candidate]] = {name: [] for name in BALANCES}
    for part in explanation.parts:
        if part.effect != part.name:
            continue
        smaller = explanation.without(part).hypothesis
        without = _losses(smaller, dataset)
        if cycles is not None and part.group == FORCE:
            without[FORCE] += float((cycles.losses(smaller) - cycles.losses(all_causes)).sum())
        for name in BALANCES:
            if without[name] - with_all[name] > DECISIVE:
                shown[name].append(part)
    return {name: of_parts(parts) for name, parts in shown.items()}


def _losses(hypothesis: Hypothesis, dataset: Dataset) -> dict[str, float]:
    """Return balance -> loss of its residuals [-]."""
    residuals = by_balance(dataset.residuals_by_run(hypothesis))
    return {name: loss(np.clip(z, -LARGEST, LARGEST)) for name, z in residuals.items()}


def probability_of(verdict: str, uncalibrated: bool) -> float:
    """
    Return the probability that an answer with a verdict is true, by Laplace's rule [-].

    :param uncalibrated: whether the sensors are known to their class only
    """
    own, other = (verdict, uncalibrated), (verdict, not uncalibrated)
    right, count = TRUE_ANSWERS.get(own) or TRUE_ANSWERS[other]
    return (right + 1.0) / (count + 2.0)
