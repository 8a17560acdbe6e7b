"""
Free runs as the judge of causes that leave the same residuals.

Small errors add up from cycle to cycle, where sensors and supply are exact: free runs distinguish
causes, and forms of one, that no window does.
"""

from collections.abc import Sequence

from pneu_rig_ros.diagnosis.causes.candidates import Explanation
from pneu_rig_ros.diagnosis.search.fitting import (
    FIRST_ROUNDS,
    ROUNDS,
    SIMPLEX_SIZE,
    Fit,
    fit,
    simplex_search,
)
from pneu_rig_ros.diagnosis.search.growth import FINALISTS, MOST_FITTED, Growth
from pneu_rig_ros.diagnosis.search.scoring import (
    NEGLIGIBLE,
    ScoredFit,
    best_of_each,
    preferred,
    residual_excess,
    score,
)
from pneu_rig_ros.executor import map_tasks

UNFINISHED = 2.0
"""Factor by which a first fit may leave more than it would after more evaluations [-]."""


def free_runs_are_off(search: Growth) -> bool:
    """
    Return whether free runs of the best explanation are off.

    Where something is significant beside it, they are off whether it is right or not.
    """
    if not search.is_exactly_known or search.training.runs_freely or search.strong_residuals():
        return False
    if search.training.cycles is not None and search.cycles_remain():
        return False
    search.progress('comparing free runs')
    return search.free_run_test(search.hypothesis).significant


def agreeing_with_free_runs(search: Growth) -> Fit | None:
    """
    Return the best explanation with values with which its free runs agree, None if none do.

    Values by the residuals alone are not sharp enough. Those by simulated cycles may be anywhere
    in a valley, whose hills a simplex search steps over.
    """
    training = search.training.with_cycles(search.hypothesis, search.rng, free=True)
    sharper = fit(search.so_far.explanation, training, ROUNDS)
    if search.training.cycles is None:
        return None if search.free_run_test(sharper.hypothesis).significant else sharper
    for size in (SIMPLEX_SIZE, -SIMPLEX_SIZE):  # the first may shrink onto a hill
        sharper = simplex_search(sharper, training, size)
        if not search.free_run_test(sharper.hypothesis).significant:
            return sharper
    return None


def preferred_by_free_runs(search: Growth, best: ScoredFit) -> ScoredFit:
    """
    Return what free runs prefer of the best explanation and others that leave as little.

    Their fits to free runs become the ranking of the search; its data stay as they are.
    """
    data = search.data
    search.data = data.without_cycles
    first = best_of_each(search.fit_all(_alternatives(search, best), FIRST_ROUNDS))
    near = _leaving_as_little(search, first, best, UNFINISHED)
    fits = search.fit_all([each.explanation for each in near], ROUNDS)
    fits = [best, *_leaving_as_little(search, fits, best)]
    search.data = search.data.with_cycles(search.hypothesis, search.rng, free=True)
    ranked = best_of_each(map_tasks(search.executor, score, fits, search.data))
    search.ranking = search.fits([each.explanation for each in ranked[:MOST_FITTED]])
    search.data = data
    return preferred(search.ranking)


def _alternatives(search: Growth, best: ScoredFit) -> list[Explanation]:
    """Return the fitted explanations of the same size, and other forms of their effects."""
    size = len(best.explanation.parts)
    fits = [each for each in search.ranking if len(each.explanation.parts) == size]
    first = [each.explanation for each in best_of_each([best, *fits])][:MOST_FITTED]
    return [*first, *search.other_forms(first[:FINALISTS])]


def _leaving_as_little(
    search: Growth, fits: Sequence[ScoredFit], best: ScoredFit, slack: float = 1.0
) -> list[ScoredFit]:
    """Return the fits that leave next to no more residual than the best one, or some more."""
    left = list(fits)
    for dataset in search.data:
        least = residual_excess(dataset, best.hypothesis)
        most = slack * max(NEGLIGIBLE * residual_excess(dataset, search.given), least)
        left = [each for each in left if residual_excess(dataset, each.hypothesis) <= most]
    return left
