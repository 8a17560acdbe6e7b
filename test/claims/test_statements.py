"""The statements of the paper that hold under the default reading, each with its margin."""

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pneu_rig_ros.claims import statements
from pneu_rig_ros.claims.dwell_law import equation_16, static_peaks
from pneu_rig_ros.claims.experiments import CAPTIONS, CYLINDERS, Laboratory, Reading
from pneu_rig_ros.claims.findings import (
    Finding,
    Row,
    at_least,
    at_most,
    falls,
    falls_throughout,
    grows,
    rises_throughout,
    unchanged,
)
from pneu_rig_ros.claims.readings import load_reading, printed_values_changed
from pneu_rig_ros.claims.search import START, reading_of
from pneu_rig_ros.claims.statements import STATEMENTS, measure, starts

HOLD = (2, 3, 4, 5, 6, 7, 9, 10)


@pytest.mark.parametrize('number', HOLD)
def test_statement_holds(rows: Sequence[Row], number: int) -> None:
    row = next(row for row in rows if row.statement.number == number)
    assert [finding.says for finding in row.findings if not finding.holds] == []


def test_stick_slip_persists_with_equation_16_and_its_cycles_are_not_those_of_rlg(
    rows: Sequence[Row],
) -> None:
    findings = next(row.findings for row in rows if row.statement.number == 8)
    assert {f.says for f in findings if not f.holds} == {
        f'{name}: and attenuates (falling peaks after the first, as in 1)'
        for name in ('cylinder_1', 'cylinder_2')
    }


def test_statements_that_do_not_hold_are_said_not_to(rows: Sequence[Row]) -> None:
    # a statement that begins to hold belongs into HOLD and into docs/decisions.md
    assert {row.statement.number for row in rows if row.holds} == set(HOLD)


@pytest.mark.parametrize(
    ('name', 'expected'), [('plainest', {10}), ('statement_1', {1, 3, 7, 10})]
)
def test_shipped_readings_hold_what_the_decisions_say(name: str, expected: set[int]) -> None:
    laboratory = Laboratory(load_reading(name))
    assert printed_values_changed(laboratory.reading) == []
    assert {s.number for s in STATEMENTS if measure(laboratory, s).holds} == expected


def test_default_is_the_known_start_of_the_search() -> None:
    known = reading_of(START)
    for name in CYLINDERS:
        shipped = Laboratory().plant(CAPTIONS[name]).model
        for key, value in known.friction_of(name).items():
            assert getattr(shipped.friction, key) == pytest.approx(value, rel=0.03), key
        assert shipped.operation.rest_time == pytest.approx(known.operation['rest_time'], rel=0.03)


def test_by_the_means_of_the_strokes_two_would_not_hold_and_six_hardly(
    laboratory: Laboratory, monkeypatch: pytest.MonkeyPatch
) -> None:
    # docs/decisions.md and the README say so
    monkeypatch.setattr(
        statements, 'middle', lambda values: float(np.mean(values)) if len(values) else np.nan
    )
    rows = [measure(laboratory, statement) for statement in STATEMENTS if statement.number in HOLD]
    findings = {row.statement.number: row.findings for row in rows}
    two, six = findings.pop(2), findings.pop(6)
    assert all(finding.holds for found in findings.values() for finding in found)
    assert [f.says for f in two if not f.holds] == ['median dwell shorter than of cylinder 1']
    (slips,) = (finding for finding in six if finding.says == 'larger slips')
    assert all(finding.holds for finding in six if finding is not slips)
    first, *_, last = map(float, re.findall(r'[0-9.]+', slips.measured))
    assert first == pytest.approx(18.2, abs=0.1)
    assert last == pytest.approx(18.2, abs=0.1)


@pytest.mark.parametrize(
    ('name', 'mean', 'longest'), [('cylinder_1', 0.78, 1.21), ('cylinder_2', 1.23, 3.51)]
)
def test_dwells_that_the_decisions_tell(
    laboratory: Laboratory, name: str, mean: float, longest: float
) -> None:
    waits = laboratory.perform(CAPTIONS[name]).column('dwell')
    assert waits.mean() == pytest.approx(mean, abs=0.02)
    assert waits.max() == pytest.approx(longest, abs=0.02)


def test_equation_16_of_cylinder_1() -> None:
    law = Laboratory().perform(CAPTIONS['cylinder_1']).plant.model.friction
    grown = equation_16(np.array([0.0, 1.0, 10.0, 100.0]), law)
    assert grown == pytest.approx([4.0, 6.3, 9.3, 13.5], abs=0.06)


def test_static_peak_is_the_largest_force_before_the_onset() -> None:
    stroke = Laboratory().perform(CAPTIONS['cylinder_1'])
    whole, before = stroke.column('peak_friction'), static_peaks(stroke)
    assert len(before) == stroke.count
    assert np.all(before <= 1.05 * whole)


@pytest.mark.parametrize(
    ('margin', 'of'),
    [
        (at_least, ((3.0, 2.0), 0.5, (1.0, 2.0), -0.5)),
        (at_most, ((1.0, 2.0), 0.5, (3.0, 2.0), -0.5)),
        (rises_throughout, (([1.0, 2.0, 3.0],), 0.5, ([1.0, 2.0, 1.0],), -0.5)),
        (falls_throughout, (([4.0, 2.0, 1.0],), 0.5, ([4.0, 2.0, 3.0],), -0.5)),
        (grows, (([np.nan, 2.0, 1.0, 3.0],), 0.5, ([1.0, np.nan],), -1.0)),
        (unchanged, (([1.0, 1.15], 0.3), 0.5, ([1.0, 1.45], 0.3), -0.5)),
        (falls, ((np.array([1.5, 1.0, 0.5]),), 1.0, (np.array([0.5, 1.0, 1.5]),), -1.0)),
    ],
)
def test_margin_is_positive_when_it_is_so(
    margin: Callable[..., float], of: tuple[tuple[Any, ...], float, tuple[Any, ...], float]
) -> None:
    so, inside, not_so, outside = of
    assert margin(*so) == pytest.approx(inside)
    assert margin(*not_so) == pytest.approx(outside)


@pytest.mark.parametrize(
    'margin',
    [
        at_least(np.nan, 1.0), at_most(1.0, 0.0), rises_throughout([1.0, np.nan, 2.0]),
        falls_throughout([2.0, 0.0, 1.0]), unchanged([1.0, np.nan], 0.3), unchanged([0.0], 0.3),
        falls(np.array([2.0, 1.0])),
    ],
)  # fmt: skip
def test_nothing_measured_does_not_hold(margin: float) -> None:
    finding = Finding('says', 'nothing', margin)
    assert not finding.holds
    assert finding.clipped_margin == -1.0
    assert Row(STATEMENTS[0], (finding,)).shortfall == 1.0


def test_stroke_starts_where_the_reading_says_unless_the_experiment_does() -> None:
    laboratory = Laboratory(Reading('further', operation={'initial_position': 0.03}))
    point = CAPTIONS['cylinder_2']
    assert laboratory.plant(point).state.position == 0.03
    assert laboratory.plant(replace(point, initial_position=0.0)).state.position == 0.0
    assert [p.initial_position for p in starts(laboratory, 'cylinder_2')] == [0.03, 0.04, 0.05]
