"""Each balance has the verdict of the causes that its residuals show."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.answer.verdict import of_balances, of_parts
from pneu_rig_ros.diagnosis.causes.candidate_pool import pool
from pneu_rig_ros.diagnosis.causes.candidates import Candidate, Explanation
from pneu_rig_ros.diagnosis.residuals.balances import BALANCES, Comparison
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset
from pneu_rig_ros.model import effects as library

from .runs import configured, measured, system_of

LEAK, FRICTION, BRISTLE = 1e-9, 'friction.coulomb_force', 'friction.element_stiffness'


@pytest.fixture(scope='module')
def found(tmp_path_factory: pytest.TempPathFactory) -> tuple[Explanation, dict[str, str]]:
    """Return a leak of chamber 1 with another friction, and the verdicts on a run with both."""
    leak = library.load('chamber_leak').null._replace(area_1=LEAK)
    rig = configured('cylinder_1', {'chamber_leak': leak})
    law = rig.model.friction
    rubs = law._replace(coulomb_force=1.2 * law.coulomb_force)
    system = system_of(tmp_path_factory.mktemp('model'), configured('cylinder_1'))
    run = measured(system, 'run', replace(rig, model=rig.model._replace(friction=rubs)))
    candidates = {each.name: each for each in pool(system, [run])[0]}
    explanation = Explanation().with_part(candidates[FRICTION], (1.2 * law.coulomb_force,))
    explanation = explanation.with_part(candidates['chamber_leak'], (LEAK, 0.0))
    data = Dataset.of(system.hypothesis, [Comparison(run)], np.random.default_rng(0))
    return explanation, of_balances(explanation, system.hypothesis, data)


def test_balances_have_verdicts_of_their_own(
    found: tuple[Explanation, dict[str, str]],
) -> None:
    assert found[1] == {'gas_1': 'effect', 'gas_2': 'consistent', 'force': 'parameter'}


def test_an_effect_counts_more_than_a_parameter(
    found: tuple[Explanation, dict[str, str]],
) -> None:
    parts: tuple[Candidate, ...] = found[0].parts
    assert [of_parts(each) for each in (parts, parts[:1], ())] == [
        'effect',
        'parameter',
        'consistent',
    ]


def test_an_explanation_without_a_part_keeps_the_other_values(
    found: tuple[Explanation, dict[str, str]],
) -> None:
    friction, leak = found[0].parts
    assert found[0].without(friction) == Explanation((leak,), ((LEAK, 0.0),))


def test_cycles_show_a_cause_of_friction_that_residuals_do_not(tmp_path: Path) -> None:
    rig = configured('cylinder_1')
    law, system = rig.model.friction, system_of(tmp_path, rig)
    softer = law._replace(element_stiffness=(0.5 * sum(law.element_stiffness),))
    run = measured(system, 'run', replace(rig, model=rig.model._replace(friction=softer)))
    candidates = {each.name: each for each in pool(system, [run])[0]}
    explanation = Explanation().with_part(candidates[BRISTLE], softer.element_stiffness)
    data = Dataset.of(system.hypothesis, [Comparison(run)], np.random.default_rng(0))
    with_cycles = data.with_cycles(system.hypothesis, np.random.default_rng(0))
    by_residuals, by_both = (
        of_balances(explanation, system.hypothesis, data, cycles)
        for cycles in (None, with_cycles.cycles)
    )
    assert by_residuals == dict.fromkeys(BALANCES, 'consistent')
    assert by_both == {**by_residuals, 'force': 'parameter'}
