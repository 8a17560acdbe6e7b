"""Which of the explanations that close a gap is taken."""

import numpy as np
import pytest

from pneu_rig_ros.gap.candidates import Candidate, effect_candidate, parameter, parameters
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.fitting import Explanation, Fit
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode
from pneu_rig_ros.gap.scoring import Scored, preferred
from pneu_rig_ros.gap.selection import GOING_ON, Search

from .runs import configured, measured

GIVEN = Hypothesis(configured('cylinder_1').model)


def scored(part: Candidate, cost: float) -> Scored:
    explanation = Explanation().plus(part, part.starts[0])
    return Scored(Fit(explanation, cost, np.ones(1)), cost)


@pytest.mark.parametrize(('cost', 'chosen'), [(0.30, 'parameter'), (0.34, 'effect')])
def test_parameter_is_preferred_to_an_effect_that_leaves_as_much(cost: float, chosen: str) -> None:
    effect = scored(effect_candidate('position_dependent_friction'), 0.27)
    force = parameter(GIVEN, 'friction.coulomb_force', 'force', (Mode.CYCLES,))
    other = scored(force, cost)
    assert preferred([other, effect]) is (other if chosen == 'parameter' else effect)


def test_two_wrong_parameters_are_found_together_and_no_third() -> None:
    mode, rng = Mode.CHAMBERS, np.random.default_rng(0)
    runs = [measured(seed=seed, supply_pressure=supply) for seed, supply in ((1, 5e5), (2, 7e5))]
    wrong = {'intake_coefficient': 0.8, 'intake_voltage': 1.01}
    given = GIVEN
    for name, factor in wrong.items():
        given = given.with_parameter('valve', name, factor * getattr(given.model.valve, name))
    pool = [one for one in parameters(given) if mode in one.modes]
    assert len(pool) > len(wrong)
    search = Search(given, Evidence(runs[:1], rng), Evidence(runs[1:], rng), (mode,), print)
    search.settle(given)
    search.begin = search.cost(given)
    found = search.jointly(pool)
    assert found is not None
    explanation = found.fit.explanation
    assert {part.name for part in explanation.parts} == {f'valve.{name}' for name in wrong}
    for part, values in zip(explanation.parts, explanation.values, strict=True):
        truth = getattr(GIVEN.model.valve, part.name.split('.')[1])
        assert values[0] == pytest.approx(truth, rel=0.01)  # one run of 8 s was fitted


def test_ranking_has_the_best_fit_of_each_explanation() -> None:
    nothing = Evidence([], np.random.default_rng(0))
    search = Search(GIVEN, nothing, nothing, (Mode.CHAMBERS,), print)
    leak, heat = effect_candidate('chamber_leak'), effect_candidate('wall_heat_transfer')
    worse, best, other = scored(leak, 0.5), scored(leak, 0.3), scored(heat, 0.4)
    search.scored = [worse, best, other]
    assert search.ranking == [best, other]


@pytest.mark.parametrize(
    ('costs', 'rounds'),
    [((50.0, 30.0, 26.0, 1.0), 3), ((50.0, 30.0, 15.0, 7.0, 1.0), GOING_ON), ((0.5, 0.1), 1)],
    ids=['until it gains no more', 'not for ever', 'until nothing is left'],
)
def test_whole_range_fits_go_on_while_they_gain(
    costs: tuple[float, ...], rounds: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    nothing = Evidence([], np.random.default_rng(0))
    search = Search(GIVEN, nothing, nothing, (Mode.CHAMBERS,), print)
    search.level = 1.0
    leak, left = effect_candidate('chamber_leak'), list(costs)
    monkeypatch.setattr(Search, 'settle', lambda search, hypothesis: None)
    monkeypatch.setattr(
        Search, 'fits', lambda search, starts, rounds: [scored(leak, left.pop(0)) for _ in starts]
    )
    (found,) = search.fitted_on([scored(leak, 90.0)])
    assert len(costs) - len(left) == rounds
    assert found.worst == costs[rounds - 1]
