"""What is known already is fitted again together with what comes on top of it."""

from dataclasses import replace

import numpy as np
import pytest

from pneu_rig_ros.gap.candidates import candidates
from pneu_rig_ros.gap.diagnosis import Diagnosis, fitted_again, reconciled
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.fitting import FINE_STEP, STEP, Explanation, Fit, fit
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode
from pneu_rig_ros.gap.scoring import Scored
from pneu_rig_ros.gap.selection import Search
from pneu_rig_ros.rig import RigConfiguration

from .runs import configured, measured

TRUE = configured('cylinder_2')
TIMELINE = ((0.5, 3.0), (0.0, 1.0), (-0.6, 2.5), (0.0, 0.7), (0.4, 2.0))
"""u [V], how long [s]: glides of both chambers' exhausts, which tell its edge and coefficient."""
WRONG = {
    'valve.exhaust_coefficient': 1.15,
    'valve.exhaust_voltage': 0.98,
    'friction.dwell_coefficient': 1.4,
}
"""What the model has, in multiples of the truth."""
VALLEY = {'valve.exhaust_coefficient': 0.99, 'valve.exhaust_voltage': 1.002}
"""Nearly as good as the truth as long as the motion is imposed."""


def true_value(name: str) -> float:
    section, key = name.split('.')
    return float(getattr(getattr(TRUE.model, section), key))


def given() -> RigConfiguration:
    hypothesis = Hypothesis(TRUE.model)
    for name, factor in WRONG.items():
        section, key = name.split('.')
        hypothesis = hypothesis.with_parameter(section, key, factor * true_value(name))
    sensors = TRUE.sensors._replace(position_class=0.0, pressure_class=0.0)
    return replace(TRUE, model=hypothesis.model, sensors=sensors)


@pytest.fixture(scope='module')
def diagnosis() -> Diagnosis:
    rng = np.random.default_rng(0)
    runs = [measured('cylinder_2', seed=seed, timeline=TIMELINE, supply_pressure=p)
            for seed, p in ((1, 5e5), (2, 6e5), (3, 5.5e5))]  # fmt: skip
    found = Diagnosis(given(), Evidence(runs[:2], rng), Evidence(runs[2:], rng))
    pool = {one.name: one for one in candidates(found.given)}
    for name, factor in VALLEY.items():
        found.explanation = found.explanation.plus(pool[name], (factor * true_value(name),))
    for mode in (Mode.CHAMBERS, Mode.CYCLES):
        known = found.explanation.apply(found.given)
        found.searches[mode] = Search(known, found.fitted, found.held, (mode,), lambda text: None)
        found.searches[mode].settle(known)
    dwell = Explanation().plus(
        pool['friction.dwell_coefficient'], (1.1 * true_value('friction.dwell_coefficient'),)
    )
    found.searches[Mode.CYCLES].scored = [Scored(Fit(dwell, 1.0, np.zeros(1)), 1.0)]
    return found


def test_values_along_a_valley_are_put_right_by_what_comes_on_top(diagnosis: Diagnosis) -> None:
    search = diagnosis.searches[Mode.CYCLES]
    assert fitted_again(diagnosis, search, diagnosis.explanation) is None
    better = reconciled(diagnosis, search, lambda text: None)
    assert better is not None
    assert [part.name for part in better.parts] == list(WRONG)
    for part, (value,) in zip(better.parts, better.values, strict=True):
        start = {**WRONG, **VALLEY}[part.name]  # where it began, in multiples of the truth
        assert value == pytest.approx(true_value(part.name), rel=0.5 * abs(start - 1.0))
        assert value == pytest.approx(true_value(part.name), rel=0.01)


def test_fine_steps_lead_to_the_end_of_a_valley(diagnosis: Diagnosis) -> None:
    # the end is where the noise puts it, which is not at the true values
    coarse, fine, end = (
        fit(diagnosis.given, diagnosis.explanation, diagnosis.fitted, (Mode.CHAMBERS,), 20, step)
        for step in (STEP, FINE_STEP, 0.1 * FINE_STEP)
    )
    assert coarse.cost - end.cost > 1e-4
    assert fine.cost - end.cost < 0.2 * (coarse.cost - end.cost)


def test_nothing_is_reconciled_where_nothing_is_known(diagnosis: Diagnosis) -> None:
    blank = replace(diagnosis, explanation=Explanation())
    assert reconciled(blank, diagnosis.searches[Mode.CYCLES], print) is None
