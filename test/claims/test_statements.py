"""The statements of the paper that hold under the default reading, each with its margin."""

from collections.abc import Sequence

import numpy as np
import pytest

from pneu_rig_ros.claims.dwell_law import equation_16
from pneu_rig_ros.claims.experiments import CAPTIONS, Laboratory
from pneu_rig_ros.claims.findings import Row, grows, unchanged

HOLD = (3, 4, 10)


@pytest.mark.parametrize('number', HOLD)
def test_statement_holds(rows: Sequence[Row], number: int) -> None:
    row = next(row for row in rows if row.statement.number == number)
    assert [finding.says for finding in row.findings if not finding.holds] == []


def test_statements_that_do_not_hold_are_said_not_to(rows: Sequence[Row]) -> None:
    # a statement that begins to hold belongs into HOLD and into docs/decisions.md
    assert {row.statement.number for row in rows if row.holds} == set(HOLD)


def test_equation_16_of_cylinder_1() -> None:
    law = Laboratory().perform(CAPTIONS['cylinder_1']).plant.model.friction
    grown = equation_16(np.array([0.0, 1.0, 10.0, 100.0]), law)
    assert grown == pytest.approx([4.0, 6.3, 9.3, 13.5], abs=0.06)


@pytest.mark.parametrize(
    ('values', 'answer'),
    [([1.0, 2.0], True), ([2.0, 1.0], False), ([np.nan, 1.0, 2.0], True), ([1.0, np.nan], False)],
)
def test_growth_needs_two_values(values: list[float], answer: bool) -> None:
    assert grows(values) == answer


@pytest.mark.parametrize(
    ('values', 'answer'),
    [([1.0, 1.2], True), ([1.0, 1.4], False), ([1.0, np.nan], False), ([np.nan, 1.0], False)],
)
def test_unchanged_needs_all_values(values: list[float], answer: bool) -> None:
    assert unchanged(values, 0.3) == answer
