"""How probable an answer and each name is said to be."""

import math

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.answer.alternatives import weights
from pneu_rig_ros.diagnosis.answer.verdict import TRUE_ANSWERS, probability_of


def test_weights_are_odds_where_all_stretches_agree_and_even_out_where_they_do_not() -> None:
    certain = np.full(100, 0.1)
    own, other = weights([certain, certain + 0.02], [0.0, 0.0])
    assert own / other == pytest.approx(math.exp(2.0))
    assert weights([certain, certain], [0.0, 2.0])[0] == pytest.approx(own)
    # one stretch makes all of a difference of 10 units, and weighs x in a sample: p(x) = exp(-x)
    one = np.where(np.arange(100) == 0, 10.0, 0.0)
    assert weights([certain, certain + one], [0.0, 0.0])[1] == pytest.approx(0.061, abs=0.01)


def test_share_of_a_verdict_is_that_of_its_trials_and_never_certain() -> None:
    """(k + 1)/(n + 2): with no answers even, with 11 of 11 no more than 12 of 13."""
    for (verdict, uncalibrated), (right, count) in TRUE_ANSWERS.items():
        assert probability_of(verdict, uncalibrated) == (right + 1) / (count + 2)
        assert 0.0 < probability_of(verdict, uncalibrated) < 1.0


def test_a_verdict_without_trials_of_such_a_system_counts_those_of_the_others() -> None:
    assert ('conditions', True) not in TRUE_ANSWERS
    assert probability_of('conditions', True) == probability_of('conditions', False)
