"""Explanations that are found over their whole range, and pairs that only help together."""

from typing import Any

import numpy as np

from pneu_rig_ros.executor import Here
from pneu_rig_ros.gap.candidates import effect_candidate
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.fitting import Explanation
from pneu_rig_ros.gap.global_fit import fit_globally, hops, span
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode
from pneu_rig_ros.gap.scoring import Setting, cost_of, fit_from
from pneu_rig_ros.gap.screening import screen_pairs
from pneu_rig_ros.model import effects

from .runs import TIMELINE, Timeline, configured, measured

MODE = (Mode.CYCLES,)
ROUNDS = 8
POOL = ('direction_dependent_friction', 'film_dynamics', 'inclination', 'load_spring')


def rig(
    law: str, hidden: dict[str, Any], *seeds: int, timeline: Timeline = TIMELINE
) -> tuple[Hypothesis, list[Evidence]]:
    """Return cylinder 1 without the hidden effects, and a run with them for each seed."""
    overrides: dict[str, Any] = {'load_mass': 2.0, 'friction': law}
    given = Hypothesis(configured('cylinder_1', **overrides).model)
    found = []
    for seed in seeds:
        run = measured(effects=hidden, seed=seed, timeline=timeline, **overrides)
        found.append(Evidence([run], np.random.default_rng(0)))
        found[-1].settle_floors(Hypothesis(given.model, hidden), MODE)
    return given, found


def test_swinging_load_is_found_where_a_fit_from_one_start_ends_elsewhere() -> None:
    truth = (3e-4, 5.0)
    hidden = {'load_compliance': effects.load('load_compliance').parameters(*truth)}
    given, (fitted, held) = rig('revised_lugre_dwell', hidden, 1, 2)
    setting, at_truth = Setting(given, fitted, held, MODE), Hypothesis(given.model, hidden)
    # ends 9 times as bad as the truth, and from starts 10 % to either side 6 to 10 times
    start = Explanation().plus(effect_candidate('load_compliance'), (1e-3, 0.5))
    assert fit_from(start, setting, ROUNDS).fit.cost > 2.0 * fitted.cost(at_truth, MODE)
    (found,) = fit_globally([start], setting, 0, Here())
    assert found.worst < 1.1 * fitted.cost(at_truth, MODE)
    assert np.allclose(found.fit.explanation.values[0], truth, rtol=0.05)


def test_hop_of_one_coordinate_leaves_a_false_valley() -> None:
    truth = (0.015, 3000.0, 300.0)
    hidden = {'end_cushion': effects.load('end_cushion').parameters(*truth)}
    off_the_cushion = ((0.5, 2.0), (0.0, 0.5))
    given, (fitted, held) = rig('revised_lugre_dwell', hidden, 1, 2, timeline=off_the_cushion)
    setting, at_truth = Setting(given, fitted, held, MODE), Hypothesis(given.model, hidden)
    # ends 9 times as bad as the truth, and from starts a little to either side 4 to 9 times
    start = Explanation().plus(effect_candidate('end_cushion'), (0.0146, 3000.0, 75.0))
    stuck = fit_from(start, setting, 3 * ROUNDS)
    assert cost_of(stuck) > 2.0 * fitted.cost(at_truth, MODE)
    best = min((fit_from(hop, setting, ROUNDS) for hop in hops(stuck, 0)), key=cost_of)
    assert cost_of(best) < 1.1 * fitted.cost(at_truth, MODE)
    assert np.allclose(best.fit.explanation.values[0], truth, rtol=0.05)


def test_two_effects_are_found_that_are_of_no_use_alone() -> None:
    # near what the library tries: slips at the wrong times make hills around the true values
    hidden = {
        'film_dynamics': effects.load('film_dynamics').parameters(20.0, 0.01, 0.32, 36.0),
        'direction_dependent_friction': effects.load('direction_dependent_friction').parameters(
            0.22
        ),
    }
    out_back_out = ((0.31, 3.0), (0.0, 0.5), (-0.5, 3.0), (0.0, 0.5), (0.31, 3.0))
    given, (run,) = rig('lugre', hidden, 1, timeline=out_back_out)
    for name, own in hidden.items():
        assert run.cost(given.with_effect(name, own), MODE) > run.cost(given, MODE)
    pool = [effect_candidate(name) for name in POOL]
    first, *_ = screen_pairs(given, Explanation(), pool, run, MODE, Here())
    assert {part.name for part in first.parts} == set(hidden)


def test_range_reaches_beyond_the_starts_and_keeps_to_the_bounds() -> None:
    for name in POOL:
        part = effect_candidate(name)
        low, high = span(part)
        seen = [
            [c.inward(v) for c, v in zip(part.coordinates, start, strict=True)]
            for start in part.starts
        ]
        bounds = np.array([c.bounds for c in part.coordinates]).T
        assert np.all(low <= np.min(seen, axis=0))
        assert np.all(np.max(seen, axis=0) <= high)
        assert np.all(bounds[0] <= low)
        assert np.all(high <= bounds[1])
