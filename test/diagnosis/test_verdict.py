"""Each balance has the verdict of the causes that its residuals show."""

from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.answer.verdict import of_balances, of_parts
from pneu_rig_ros.diagnosis.causes.candidate_pool import pool
from pneu_rig_ros.diagnosis.causes.candidates import Candidate, Explanation
from pneu_rig_ros.diagnosis.residuals.balances import BALANCES
from pneu_rig_ros.model import effects as library

from .runs import changed, configured, data_of, measured, system_of

LEAK, FRICTION, BRISTLE = 1e-9, 'friction.coulomb_force', 'friction.element_stiffness'


@pytest.fixture(scope='module')
def found(tmp_path_factory: pytest.TempPathFactory) -> tuple[Explanation, dict[str, str]]:
    """Return a leak of chamber 1 with another friction, and the verdicts on a run with both."""
    leak = library.load('chamber_leak').null._replace(area_1=LEAK)
    rig = configured('cylinder_1', {'chamber_leak': leak})
    higher = 1.2 * rig.model.friction.coulomb_force
    system = system_of(tmp_path_factory.mktemp('model'), configured('cylinder_1'))
    run = measured(system, 'run', changed(rig, 'friction', coulomb_force=higher))
    candidates = {each.name: each for each in pool(system, [run])[0]}
    explanation = Explanation(system.hypothesis).with_part(candidates[FRICTION], (higher,))
    explanation = explanation.with_part(candidates['chamber_leak'], (LEAK, 0.0))
    data = data_of(system.hypothesis, run)
    return explanation, of_balances(explanation, data)


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
    assert found[0].without(friction) == Explanation(found[0].given, (leak,), ((LEAK, 0.0),))


def test_cycles_show_a_cause_of_friction_that_residuals_do_not(tmp_path: Path) -> None:
    rig = configured('cylinder_1')
    softer, system = (0.5 * sum(rig.model.friction.element_stiffness),), system_of(tmp_path, rig)
    run = measured(system, 'run', changed(rig, 'friction', element_stiffness=softer))
    candidates = {each.name: each for each in pool(system, [run])[0]}
    explanation = Explanation(system.hypothesis).with_part(candidates[BRISTLE], softer)
    data = data_of(system.hypothesis, run)
    with_cycles = data.with_cycles(system.hypothesis, np.random.default_rng(0))
    by_residuals, by_both = (
        of_balances(explanation, data, cycles) for cycles in (None, with_cycles.cycles)
    )
    assert by_residuals == dict.fromkeys(BALANCES, 'consistent')
    assert by_both == {**by_residuals, 'force': 'parameter'}
