"""
How probable it is that a verdict, and each name, is true.

The share of a verdict is counted: how often answers with it were true in trials whose laws all
differ from those of the library, of systems whose sensors are exact or known to their class only.
What was fitted shares it by pseudo-BMA+ weights (Y. Yao et al.,
Bayesian Anal. 13 (2018) 917): by the log predictive densities of stretches of the runs, under a
Bayesian bootstrap of these.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from scipy.special import softmax

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.search.scoring import ScoredFit
from pneu_rig_ros.diagnosis.search.selection import Search

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
DRAWS, SEED = 2000, 1
"""Of the bootstrap."""

Names = frozenset[str]


def of_verdict(verdict: str, uncalibrated: bool) -> float:
    """
    Return the probability that an answer with a verdict is true, by Laplace's rule [-].

    :param uncalibrated: whether the sensors are known to their class only
    """
    own, other = (verdict, uncalibrated), (verdict, not uncalibrated)
    right, count = TRUE_ANSWERS.get(own) or TRUE_ANSWERS[other]
    return (right + 1.0) / (count + 2.0)


def of_names(
    search: Search, explanation: Explanation, named: bool, share: float
) -> dict[Names, float]:
    """
    Return the names of causes -> probability that they are what is missing [-].

    Those of one size that can be compared; what is left of 1 is for a cause that was not fitted.
    Of a verdict without a name they share what that leaves.

    :param named: whether the verdict names a cause
    :param share: probability of the verdict [-]
    """
    share = share if named else 1.0 - share
    fits = _comparable(search, explanation)
    found = weights([fit.losses for fit in fits.values()], [fit.penalty for fit in fits.values()])
    return dict(zip(fits, (share * found).tolist(), strict=True))


def _comparable(search: Search, explanation: Explanation) -> dict[Names, ScoredFit]:
    """Return the fits of as many causes as an explanation has, on the same data; or of one."""
    own = frozenset(search.causes(explanation))
    ranked = first_of_each(search, search.ranking).items()
    fits = {names: fit for names, fit in ranked if len(names) == max(len(own), 1)}
    if not fits:
        return {}
    size = fits.get(own, next(iter(fits.values()))).losses.size
    return {names: fit for names, fit in fits.items() if fit.losses.size == size}


def first_of_each(search: Search, fits: Iterable[ScoredFit]) -> dict[Names, ScoredFit]:
    """Return the names of causes, in whatever order they came -> the first fit of them."""
    found: dict[Names, ScoredFit] = {}
    for fit in fits:
        if names := frozenset(search.causes(fit.explanation)):
            found.setdefault(names, fit)
    return found


def weights(losses: Sequence[Floats], penalties: Sequence[float]) -> Floats:
    """Return the weight of each explanation [-], by its penalty and losses of n stretches."""
    if not losses:
        return np.zeros(0)
    table = np.array(losses)
    n = table.shape[1]
    shares = np.random.default_rng(SEED).dirichlet(np.ones(n), DRAWS)
    density = -n * shares @ table.T - np.array(penalties)
    mean: Floats = softmax(density, axis=1).mean(axis=0)
    return mean
