"""
Profiles: a mechanism without its formula, as a free function of the variable that drives it.

Where no formula of the library closes the gap, the mechanism may still be known: friction that
depends on the position, however it does, a leak that depends on the pressure. A profile is linear
between knots; its values are fitted like any cause, to the residuals alone.
"""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple, cast

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.causes.candidates import Candidate, Coordinate
from pneu_rig_ros.diagnosis.causes.shaped_effects import knots
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset
from pneu_rig_ros.diagnosis.search.empirical import projection, robust_weights
from pneu_rig_ros.diagnosis.search.fitting import ROUNDS, fit
from pneu_rig_ros.diagnosis.search.scoring import MUCH_BETTER, ScoredFit, improves, score
from pneu_rig_ros.diagnosis.search.selection import Search
from pneu_rig_ros.executor import map_tasks
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.quantity import Quantity, specifications
from pneu_rig_ros.model.shape import KNOTS, Shape, Shaped

FITTED = 3
"""Profiles that are fitted, of those that explain most by linear regression."""
LARGEST = 1e3
"""Value of a profile at most [unit of its terms]."""


class Mechanism(NamedTuple):
    """
    What a mechanism of the library is as a profile.

    :param carrier: empirical effect that has the profile
    :param terms: of that effect, each with its size [SI], which the profile multiplies; of several
        choices each is tried
    :param variables: over which the profile may be
    """

    carrier: str
    terms: Sequence[Mapping[str, float]]
    variables: Sequence[str]


def _friction(*variables: str) -> Mechanism:
    return Mechanism('empirical_friction', ({'constant': 0.3},), variables)


LEAKS = (
    {'gauge_1_1': -1e-6},
    {'gauge_2_2': -1e-6},
    {'gauge_1_1': -1e-6, 'gauge_2_2': -1e-6},
)
MECHANISMS = {
    'position_dependent_friction': _friction('position'),
    'pressure_dependent_friction': _friction('pressure_1', 'pressure_2', 'difference'),
    'stribeck': _friction('speed'),
    'direction_dependent_friction': _friction('velocity'),
    'load_spring': Mechanism('empirical_force', ({'constant': 0.5},), ('position',)),
    'inclination': Mechanism('empirical_force', ({'mass': 0.5},), ('position',)),
    'nonlinear_opening': Mechanism(
        'empirical_voltage', ({'constant_1': 0.01, 'constant_2': 0.01},), ('opening',)
    ),
    'chamber_leak': Mechanism('empirical_flow', LEAKS, ('pressure',)),
    'cross_piston_leak': Mechanism(
        'empirical_flow', ({'difference_1': -1e-6, 'difference_2': 1e-6},), ('difference',)
    ),
    'wall_heat_transfer': Mechanism(
        'empirical_heat',
        ({'cold_1_1': 1.0, 'cold_2_2': 1.0},),
        ('temperature', 'pressure', 'position'),
    ),
}
"""Effect of the library -> its profile."""
NOT_NEGATIVE = 'empirical_flow', 'empirical_heat'
"""Carriers of which no profile is negative."""


@dataclass(frozen=True)
class Profile(Candidate):
    """
    A mechanism as a profile; its coordinates are the values at the knots.

    :param carrier, terms: see :class:`Mechanism`
    :param over: the variable
    :param at: its knots, increasing [unit of the variable], shape (n,)
    """

    carrier: str = ''
    terms: Mapping[str, float] = field(default_factory=dict)
    over: str = ''
    at: tuple[float, ...] = ()

    @property
    def size(self) -> float:
        """Size of the first term, by which the values at the knots are multiplied [SI]."""
        return next(iter(self.terms.values()))

    @property
    def unit(self) -> str:
        """Unit of that size, with what the term is multiplied by."""
        specification = specifications(library.load(self.carrier).parameters)
        quantity = cast(Quantity, specification[next(iter(self.terms))])
        times = quantity.description.split(', times ')[-1]
        return quantity.unit if times == '1' else f'{quantity.unit} x ({times})'

    def shape(self, values: Sequence[float]) -> Shape:
        """Return the profile with these values at its knots."""
        return Shape(self.over, self.at, tuple(float(value) for value in values))

    def apply(self, hypothesis: Hypothesis, values: Sequence[float]) -> Hypothesis:
        """Return the hypothesis with the empirical effect that has this profile."""
        parameters = library.load(self.carrier).null._replace(**self.terms)
        return hypothesis.with_effect(self.carrier, Shaped(parameters, self.shape(values)))


def profiles(search: Search) -> Iterator[Profile]:
    """Yield profiles of what is in the pool and acts where residuals are significant."""
    runs = [comparison.run for comparison in search.training.comparisons]
    temperature = search.given.model.gas.supply_temperature
    known = {candidate.name: candidate for candidate in search.pool}
    balances = {residual.balance[:3] for residual in search.significant()}
    for mechanism, (carrier, terms, variables) in MECHANISMS.items():
        cause = known.get(mechanism)
        if cause is None or cause.group[:3] not in balances:
            continue
        lowest = 0.0 if carrier in NOT_NEGATIVE else -LARGEST
        quantity = Quantity('-', lowest, LARGEST, 'of the profile')
        coordinates = tuple(
            Coordinate(f'value_{i}', quantity, lowest, LARGEST, 1.0, False)
            for i in range(1, KNOTS + 1)
        )
        new = Profile(mechanism, cause.balance, coordinates, ((0.0,) * KNOTS,), carrier=carrier)
        for each, over in itertools.product(terms, variables):
            if (at := knots(over, runs, temperature, KNOTS)) is not None:
                yield replace(new, terms=each, over=over, at=at)


def rival_profile(search: Search, named: ScoredFit | None) -> ScoredFit | None:
    """
    Return the likeliest profile in place of a cause, None where a name is as good.

    It has to leave less than half of what the name leaves, and to be decisively likelier.

    :param search: returned to its start, without simulation
    :param named: the best explanation so far
    """
    profile = _likeliest(search)
    if profile is None:
        return None
    other = score(named or search.so_far, search.data)
    less = search.left_by(profile) <= MUCH_BETTER * search.left_by(other)
    return profile if less and improves(profile, other) else None


def adopt(search: Search, profile: ScoredFit) -> None:
    """Take a profile for the explanation."""
    search.best = profile
    # others are compared with it under the same noise
    search.ranking = [profile, *(score(each, search.data) for each in search.ranking)]


def _likeliest(search: Search) -> ScoredFit | None:
    """Return the likeliest profile, None where there is none."""
    given, training = search.hypothesis, search.training
    residual = training.residual(given)
    candidates = list(profiles(search))
    explained = map_tasks(search.executor, _explained, candidates, given, training, residual)
    order = np.argsort(explained, kind='stable')[::-1][:FITTED]
    start = search.so_far.explanation
    starts = [start.with_part(candidates[i], candidates[i].starts[0]) for i in order]
    fits = map_tasks(search.executor, fit, starts, training, ROUNDS)
    scored = [score(each, search.data) for each in fits]
    return min(scored, key=lambda each: each.cost, default=None)


def _explained(profile: Profile, given: Hypothesis, dataset: Dataset, residual: Floats) -> float:
    """Return how much of a residual a profile explains by robust linear regression [-]."""
    weights = robust_weights(residual)
    columns = [
        dataset.residual(profile.apply(given, row.tolist())) - residual
        for row in np.eye(len(profile.at))
    ]
    return projection(np.column_stack(columns) * weights[:, np.newaxis], -residual * weights)
