"""What an explanation is worth on runs that it was not fitted to."""

import numpy as np
import pytest

from pneu_rig_ros.gap.candidates import effect_candidate
from pneu_rig_ros.gap.diagnosis import Diagnosis, judge
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.fitting import Explanation
from pneu_rig_ros.gap.prediction import Mode
from pneu_rig_ros.gap.selection import Search
from pneu_rig_ros.model import effects

from .runs import configured, measured

LEAK = 4e-9


@pytest.mark.parametrize(
    ('area', 'verdict', 'kept'),
    [(LEAK, 'effect', True), (0.5 * LEAK, 'unknown', True), (-LEAK, 'unknown', False)],
    ids=['all of it', 'half of it', 'the wrong chamber'],
)
def test_explanation_is_judged_by_what_it_leaves(area: float, verdict: str, kept: bool) -> None:
    hidden = {'chamber_leak': effects.load('chamber_leak').null._replace(area_1=LEAK)}
    rng = np.random.default_rng(0)
    runs = [measured(effects=hidden, seed=seed) for seed in (1, 2)]
    diagnosis = Diagnosis(
        configured('cylinder_1'), Evidence(runs[:1], rng), Evidence(runs[1:], rng)
    )
    values = (area, 0.0) if area > 0.0 else (0.0, -area)
    diagnosis.explanation = Explanation().plus(effect_candidate('chamber_leak'), values)
    search = Search(
        diagnosis.given, diagnosis.fitted, diagnosis.held, (Mode.CHAMBERS,), lambda text: None
    )
    search.settle(diagnosis.given)
    diagnosis.searches[Mode.CHAMBERS] = search
    judge(diagnosis)
    assert diagnosis.verdict == verdict
    assert bool(diagnosis.explanation.parts) is kept
