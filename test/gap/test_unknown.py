"""A description puts the gap on the balance that it comes from."""

from typing import Any

import numpy as np
import pytest

from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode
from pneu_rig_ros.gap.selection import Search
from pneu_rig_ros.gap.unknown import Description, describe
from pneu_rig_ros.model import effects
from pneu_rig_ros.rig import load_configuration

from .runs import measured

LAG = 0.008
"""Time constant of the sensor [s]."""


def described(name: str, **values: float) -> Description:
    """Return how runs of cylinder 2 with a hidden effect are described."""
    hidden: dict[str, Any] = {name: effects.load(name).null._replace(**values)}
    rng = np.random.default_rng(0)
    runs = [
        measured('cylinder_2', hidden, seed=seed, supply_pressure=supply)
        for seed, supply in ((1, 5e5), (2, 7e5))
    ]
    fitted, held = Evidence(runs[:1], rng), Evidence(runs[1:], rng)
    given, mode = Hypothesis(load_configuration('cylinder_2').model, {}), Mode.CHAMBERS
    search = Search(given, fitted, held, (mode,), lambda text: None)
    search.settle(given)
    assert search.cost(given) > search.limit
    return describe(given, fitted, held, mode, search.level, search.limit)


def test_slow_position_sensor_is_put_on_the_sensor() -> None:
    one = described('sensor_delay', time_constant=LAG)
    assert (one.balance, one.unit) == ('motion reading', 'm')
    (term,) = one.fit.explanation.values
    names = [c.name for c in one.fit.explanation.coordinates]
    # behind by speed times the time constant; the coefficient is per 0.1 m/s
    assert term[names.index('velocity')] == pytest.approx(-0.1 * LAG, rel=0.1)
    assert one.gap_left < 0.1


def test_leak_is_not_put_on_a_sensor() -> None:
    one = described('chamber_leak', area_1=2e-9)
    assert one.balance == 'gas mass 1'
    assert one.fit.explanation.parts[0].name == 'described_flow'
