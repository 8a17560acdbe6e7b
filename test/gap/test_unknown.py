"""A description puts the gap on the balance that it comes from."""

from typing import Any

import numpy as np
import pytest

from pneu_rig_ros.executor import Here
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.fitting import Fit
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode
from pneu_rig_ros.gap.scoring import score
from pneu_rig_ros.gap.selection import Search
from pneu_rig_ros.gap.unknown import Description, describe, explained, shrinking, terms_of
from pneu_rig_ros.model import effects
from pneu_rig_ros.rig import load_configuration

from .runs import measured

LAG = 0.008
"""Time constant of the sensor [s]."""


def searched(name: str, mode: Mode, **values: float) -> Search:
    """Return a search on runs of cylinder 2 with a hidden effect, one fitted, one left out."""
    hidden: dict[str, Any] = {name: effects.load(name).null._replace(**values)}
    rng = np.random.default_rng(0)
    runs = [
        measured('cylinder_2', hidden, seed=seed, supply_pressure=supply)
        for seed, supply in ((1, 5e5), (2, 7e5))
    ]
    fitted, held = Evidence(runs[:1], rng), Evidence(runs[1:], rng)
    given = Hypothesis(load_configuration('cylinder_2').model, {})
    search = Search(given, fitted, held, (mode,), lambda text: None)
    fitted.settle_floors(given, (Mode.CHAMBERS,))  # these are always looked at first
    search.settle(given)
    assert search.cost(given) > search.limit
    return search


def described(name: str, mode: Mode = Mode.CHAMBERS, **values: float) -> Description:
    """Return how runs of cylinder 2 with a hidden effect are described."""
    one = searched(name, mode, **values)
    return describe(one.given, one.fitted, one.held, mode, one.level, one.limit, Here())


def test_slow_position_sensor_is_put_on_the_sensor() -> None:
    one = described('sensor_delay', time_constant=LAG)
    assert (one.balance, one.unit) == ('motion reading', 'm')
    (term,) = one.explanation.values
    names = [c.name for c in one.explanation.coordinates]
    # a lag is speed times its time constant to first order only, less where the speed changes
    # within it; the coefficient is per 0.1 m/s
    interval = load_configuration('cylinder_2').interval_ns * 1e-9
    assert term[names.index('velocity')] == pytest.approx(-0.1 * LAG, abs=0.1 * interval)
    assert one.gap_left < 0.1


def test_leak_is_not_put_on_a_sensor() -> None:
    one = described('chamber_leak', area_1=2e-9)
    assert one.balance == 'gas mass 1'
    assert one.explanation.parts[0].name == 'described_flow'


def test_friction_that_differs_between_out_and_back_is_described_at_rest_too() -> None:
    asymmetry = 0.12
    one = described('direction_dependent_friction', Mode.CYCLES, asymmetry=asymmetry)
    terms = terms_of(one.explanation)
    law = load_configuration('cylinder_2').model.friction
    # F_c is small in this cylinder: it is the level at rest that counts
    assert terms['static_direction'] == pytest.approx(asymmetry * law.breakaway_force, rel=0.1)
    assert one.balance == 'force'
    assert one.gap_left < 0.1


def test_description_that_shrinks_nothing_is_left_out() -> None:
    search = searched('chamber_leak', Mode.CHAMBERS, area_1=2e-9)
    leak, source = (explained('described_flow', {'gauge_1': flow}) for flow in (-2e-6, 2e-6))
    good, bad = (score(Fit(one, 0.0, np.ones(1)), search.setting) for one in (leak, source))
    assert list(shrinking([bad, good], search.setting)) == [good]
    assert list(shrinking([bad], search.setting)) == []
