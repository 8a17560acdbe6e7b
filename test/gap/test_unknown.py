"""A description puts the gap on the balance that it comes from."""

from typing import Any

import numpy as np
import pytest

from pneu_rig_ros.executor import Here
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.fitting import Fit
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode, predict
from pneu_rig_ros.gap.scoring import Scored, score
from pneu_rig_ros.gap.selection import Search
from pneu_rig_ros.gap.terms import explained, terms_of
from pneu_rig_ros.gap.unknown import Description, describe, shrinking, sparsest
from pneu_rig_ros.model import effects

from .runs import TIMELINE, Timeline, configured, measured

LAG = 0.008
"""Time constant of the sensor [s]."""
STROKES = ((0.6, 2.0), (0.0, 1.0), (0.9, 1.5), (0.0, 0.7), (-0.6, 2.0))
"""u [V] and how long [s], without slips: in a slip, a lag is more than a multiple of the speed."""


def searched(name: str, mode: Mode, timeline: Timeline = TIMELINE, **values: float) -> Search:
    """Return a search on runs of cylinder 2 with a hidden effect, one fitted, one left out."""
    hidden: dict[str, Any] = {name: effects.load(name).null._replace(**values)}
    rng = np.random.default_rng(0)
    runs = [
        measured('cylinder_2', hidden, seed, timeline, supply_pressure=supply)
        for seed, supply in ((1, 5e5), (2, 7e5))
    ]
    fitted, held = Evidence(runs[:1], rng), Evidence(runs[1:], rng)
    given = Hypothesis(configured('cylinder_2').model, {})
    search = Search(given, fitted, held, (mode,), lambda text: None)
    fitted.settle_floors(given, (Mode.CHAMBERS,))  # these are always looked at first
    search.settle(given)
    assert search.cost(given) > search.limit
    return search


def described(
    name: str, mode: Mode = Mode.CHAMBERS, timeline: Timeline = TIMELINE, **values: float
) -> Description:
    """Return how runs of cylinder 2 with a hidden effect are described."""
    one = searched(name, mode, timeline, **values)
    return describe(one.given, one.fitted, one.held, mode, one.limit, Here())


def test_slow_position_sensor_is_put_on_the_sensor() -> None:
    one = described('sensor_delay', timeline=STROKES, time_constant=LAG)
    assert (one.balance, one.unit) == ('motion reading', 'm')
    terms = terms_of(one.explanation)
    search = searched('sensor_delay', Mode.CHAMBERS, STROKES, time_constant=LAG)
    hidden = search.given.with_effect('sensor_delay', effects.load('sensor_delay').parameters(LAG))
    run = predict(hidden, search.fitted.experiments[0], Mode.FREE).run
    # what the reading lacks, as a multiple of the speed: least squares
    lack, speed = run.position_reading - run.position, run.velocity / 0.1
    assert terms['velocity'] == pytest.approx(float(lack @ speed / (speed @ speed)), rel=0.1)
    assert one.gap_left < 0.1


def test_leak_is_not_put_on_a_sensor() -> None:
    one = described('chamber_leak', area_1=2e-9)
    assert one.balance == 'gas mass 1'
    assert one.explanation.parts[0].name == 'described_flow'


def test_heat_of_the_walls_is_described_as_what_cold_gas_takes() -> None:
    one = described('wall_heat_transfer', conductance_1=0.2, conductance_2=0.2)
    assert terms_of(one.explanation) == {'cold': pytest.approx(0.2, rel=0.1)}
    assert one.term.startswith('described_heat: 0.')
    assert one.balance.startswith('gas mass')
    assert one.gap_left < 0.1


def test_slow_spool_is_described_by_what_it_remembers() -> None:
    one = described('valve_lag', time_constant=0.04)
    assert one.explanation.parts[0].name == 'described_voltage'
    assert terms_of(one.explanation)['change'] < -1.0  # slower than the memory of the term
    assert one.gap_left < 0.3


def test_friction_that_differs_between_out_and_back_is_described_at_rest_too() -> None:
    asymmetry = 0.12
    one = described('direction_dependent_friction', Mode.CYCLES, asymmetry=asymmetry)
    terms = terms_of(one.explanation)
    law = configured('cylinder_2').model.friction
    # F_c is small in this cylinder: it is the level at rest that counts
    assert terms['static_direction'] == pytest.approx(asymmetry * law.breakaway_force, rel=0.1)
    assert one.balance == 'force'
    assert one.gap_left < 0.1


def test_description_that_shrinks_nothing_is_left_out() -> None:
    search = searched('chamber_leak', Mode.CHAMBERS, area_1=2e-9)
    leak, source = (explained('described_flow', {'gauge_1': flow}) for flow in (-2e-6, 2e-6))
    good, bad = (score(Fit(one, 0.0, np.ones(1)), search.setting) for one in (leak, source))
    best, left = shrinking([bad, good], search.setting, search.limit)
    assert best is good
    assert 0.0 <= left < 1.0
    assert shrinking([bad], search.setting, search.limit) == (None, 1.0)


def test_fewest_terms_that_close_the_gap_are_enough() -> None:
    one, two = (
        explained('described_flow', dict.fromkeys(names, 1e-6))
        for names in (['gauge_1'], ['gauge_1', 'voltage_1'])
    )

    def costing(first: float, second: float) -> list[Scored]:
        pairs = zip((one, two), (first, second), strict=True)
        return [Scored(Fit(which, cost, np.ones(1)), cost) for which, cost in pairs]

    few, many = costing(0.5, 0.2)
    assert sparsest([many, few], limit=0.6) is few
    assert sparsest([many, few], limit=0.4) is many
    few, many = costing(1.0, 0.95)
    assert sparsest([many, few], limit=0.4) is few
