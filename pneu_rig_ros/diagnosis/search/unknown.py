"""Whether what a cause leaves is better described by empirical terms: the verdict `unknown`."""

from __future__ import annotations

from collections.abc import Sequence

from pneu_rig_ros.diagnosis.residuals.dataset import rms
from pneu_rig_ros.diagnosis.residuals.localisation import NOISE_ERROR, SignificantResidual
from pneu_rig_ros.diagnosis.search.empirical import Description, describe
from pneu_rig_ros.diagnosis.search.fitting import Fit
from pneu_rig_ros.diagnosis.search.growth import DISCREPANT
from pneu_rig_ros.diagnosis.search.profiles import adopt_profile
from pneu_rig_ros.diagnosis.search.remainder import NEGLIGIBLE
from pneu_rig_ros.diagnosis.search.scoring import (
    MOST_LEFT,
    MOST_LEFT_ALONE,
    MOST_LEFT_OF_ALL,
    MOST_LEFT_REPORTED,
    MUCH_BETTER,
    improves,
    remaining_share,
    score,
)
from pneu_rig_ros.diagnosis.search.selection import Search


def describe_unknown(search: Search, where: Sequence[SignificantResidual]) -> Description | None:
    """
    Return empirical terms in place of the best explanation; None where that is as good.

    A cause with a name has to leave little, and about as little as a formula without one.
    """
    named, data = search.best, (search.training, search.held_out)
    # the noise of the sensors is no measure of what a cause may leave where all models are far off
    discrepant = rms(search.training.whitened(search.hypothesis)) > DISCREPANT
    reported = search.remaining()
    search.restart()
    if search.residuals_significant and adopt_profile(search, named):
        return None
    description = describe(search, (where or search.cycle_residuals())[0])
    if named is None or named is search.calibrated:
        return description
    # on the data on which the description was judged, with their noise
    better = named.explanation.apply(search.given)
    share = remaining_share(search.held_out, search.hypothesis, better)
    is_effect = any(part.is_effect for part in named.explanation.parts)
    terms = description.explanation
    formula = score(Fit(terms), search.hypothesis, *data)
    likelier = improves(formula, score(Fit(named.explanation), search.given, *data))
    beaten = likelier and NOISE_ERROR * description.gap_left < share
    allowed = MOST_LEFT if beaten else MOST_LEFT_ALONE
    if not beaten and reported <= MOST_LEFT:  # much of the share is noise under the given model
        allowed = MOST_LEFT_OF_ALL
    if discrepant and is_effect:
        allowed = MOST_LEFT_OF_ALL
    # a parameter keeps the form of the model: much of what it leaves has another cause
    elif reported > (MOST_LEFT_REPORTED if is_effect else MOST_LEFT):
        return description
    much_better = share > NEGLIGIBLE and description.gap_left < MUCH_BETTER * share
    # a formula with as few numbers needs no more than to be decisively likelier
    as_simple = not discrepant and len(terms.coordinates) <= len(named.explanation.coordinates)
    if share > allowed or (likelier and (much_better or as_simple)):
        return description
    search.best, (search.training, search.held_out) = named, data
    return None
