"""
How likely the answer is among what was fitted beside it: pseudo-BMA+ weights.

Y. Yao, A. Vehtari, D. Simpson, A. Gelman, Bayesian Anal. 13 (2018) 917. The weights are of
explanations of one size, by the log predictive densities of stretches of the runs, which a
Bayesian bootstrap weights anew. Whether they are as often right as they say is for the trials to
show: they are no part of an answer.
"""

from typing import Any

import numpy as np

DRAWS, SEED = 2000, 1


def weight_of_answer(diagnosis: Any) -> float | None:
    """Return the weight of the named explanation, None of an answer without a name."""
    search, own = diagnosis.search, frozenset(diagnosis.search.causes(diagnosis.explanation))
    size = len(diagnosis.explanation.parts)
    fits: dict[frozenset[str], Any] = {}
    for fit in search.ranking:
        if len(fit.explanation.parts) == size:
            fits.setdefault(frozenset(search.causes(fit.explanation)), fit)
    if diagnosis.verdict not in ('effect', 'parameter') or own not in fits:
        return None
    same = {k: fit for k, fit in fits.items() if fit.losses.size == fits[own].losses.size}
    found = weights([fit.losses for fit in same.values()], [fit.penalty for fit in same.values()])
    return float(found[list(same).index(own)])


def weights(losses: list[Any], penalties: list[float]) -> Any:
    """
    Return the weight of each explanation, shape (k,).

    :param losses: negative log densities of n stretches, shape (n,) each
    :param penalties: for what was fitted
    """
    table = np.array(losses)
    n = table.shape[1]
    shares = np.random.default_rng(SEED).dirichlet(np.ones(n), DRAWS)
    density = -n * shares @ table.T - np.array(penalties)
    odds = np.exp(density - density.max(axis=1, keepdims=True))
    return (odds / odds.sum(axis=1, keepdims=True)).mean(axis=0)
