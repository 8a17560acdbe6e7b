"""Whether what a cause leaves is better described by empirical terms: the verdict `unknown`."""

from collections.abc import Sequence
from typing import NamedTuple

from pneu_rig_ros.diagnosis.residuals.dataset import rms
from pneu_rig_ros.diagnosis.residuals.localisation import NOISE_ERROR, SignificantResidual
from pneu_rig_ros.diagnosis.search.empirical import Description, describe
from pneu_rig_ros.diagnosis.search.fitting import Fit
from pneu_rig_ros.diagnosis.search.growth import DISCREPANT
from pneu_rig_ros.diagnosis.search.profiles import adopt, rival_profile
from pneu_rig_ros.diagnosis.search.scoring import (
    LITTLE_LEFT,
    MOST_LEFT,
    MOST_LEFT_REPORTED,
    MUCH_BETTER,
    NEARLY_ALL_LEFT,
    NEGLIGIBLE,
    Data,
    ScoredFit,
    improves,
    score,
)
from pneu_rig_ros.diagnosis.search.selection import Search


class NameTest(NamedTuple):
    """
    A name beside a description, on the held-out data.

    :param left: share of the excess that the name leaves, with the noise under the given model [-]
    :param reported: the same with the noise that the data have if it is true [-]; 0 if
        that is noise
    :param described: what the description leaves, as ``left`` [-]
    :param likelier: whether the description is, decisively
    :param as_simple: whether it has no more fitted values than the name
    :param is_effect: whether the name has an effect, and not parameters alone
    :param discrepant: whether all models are far off: the noise of the sensors is then no measure
    """

    left: float
    reported: float
    described: float
    likelier: bool
    as_simple: bool
    is_effect: bool = True
    discrepant: bool = False

    @property
    def accepts_name(self) -> bool:
        """Whether the name leaves little, and about as little as the description."""
        much_better = self.left > NEGLIGIBLE and self.described < MUCH_BETTER * self.left
        as_simple = self.as_simple and not self.discrepant
        if self.likelier and (much_better or as_simple):
            return False
        if self.discrepant and self.is_effect:
            return self.left <= NEARLY_ALL_LEFT
        # a parameter keeps the form of the model: much of what it leaves has another cause
        if self.reported > (MOST_LEFT_REPORTED if self.is_effect else LITTLE_LEFT):
            return False
        if self.likelier and NOISE_ERROR * self.described < self.left:
            return self.left <= LITTLE_LEFT
        # else most of what is left is noise if the name is true
        return self.left <= (NEARLY_ALL_LEFT if self.reported <= LITTLE_LEFT else MOST_LEFT)


def name_or_description(
    search: Search, significant: Sequence[SignificantResidual]
) -> Description | None:
    """
    Return empirical terms in place of the best explanation.

    None where that is as good, or a profile of a mechanism is, which is then the best explanation.
    """
    named, data = search.best, search.data
    has_cause = search.has_cause
    discrepant = rms(search.training.whitened(search.hypothesis)) > DISCREPANT
    reported = search.remaining_beyond_noise() if has_cause else 1.0
    search.restart()
    profile = rival_profile(search, named) if search.residuals_significant else None
    if profile is not None and search.left_by(profile) <= LITTLE_LEFT:
        adopt(search, profile)
        return None
    description = describe(search, significant[0])
    if profile is not None:
        left = search.left_by(profile)
        if name_test(search, profile, description, search.data, left).accepts_name:
            adopt(search, profile)
            return None
    if named is None or not has_cause:
        return description
    if not name_test(search, named, description, data, reported, discrepant).accepts_name:
        return description
    search.best, search.data = named, data
    return None


def name_test(
    search: Search,
    name: ScoredFit,
    description: Description,
    data: Data,
    reported: float,
    discrepant: bool = False,
) -> NameTest:
    """
    Return a name beside a description that a search has found from its start.

    Residuals alone compare them: a description is not fitted to simulated cycles.

    :param data: with whose noise they are compared, training and held-out
    """
    terms, explanation = description.explanation, name.explanation
    formula, named = (score(Fit(each), data.without_cycles) for each in (terms, explanation))
    return NameTest(
        # on the data on which the description was judged, with their noise
        left=search.left_by(name),
        reported=reported,
        described=description.gap_left,
        likelier=improves(formula, named),
        as_simple=len(terms.coordinates) <= len(explanation.coordinates),
        is_effect=any(part.is_effect for part in explanation.parts),
        discrepant=discrepant,
    )
