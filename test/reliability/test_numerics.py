"""Random rigs in short, and those that once did what cannot be."""

from __future__ import annotations

import json

import numpy as np
import pytest

from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.plant import Plant
from reliability.balances import problems, residuals
from reliability.numerics import HARDEST_FILE, outcome, summary, text
from reliability.random_rigs import case

LAGS_EMPTIED = (1118, 1499)
"""Cases in which a lagging line once took more gas out of a chamber than was in it."""
CHATTERED = 8301
"""Breakaway and arrest at one velocity once followed each other half a million times in 1 ms."""
HARDEST = {int(seed): level for seed, level in json.loads(HARDEST_FILE.read_text()).items()}
"""Seed -> how closely it has to be looked at."""
SHARE = 0.2
"""Of the hardest runs, so that they take seconds here; ``make numerics`` simulates all of them."""


@pytest.mark.parametrize('seed', sorted({*HARDEST, *LAGS_EMPTIED, CHATTERED}))
def test_hard_cases_do_what_is_possible(seed: int) -> None:
    share = SHARE if seed in HARDEST else 1.0
    assert outcome(seed, HARDEST.get(seed, 0), share).problems == ()


def test_random_rigs_do_what_is_possible() -> None:
    outcomes = [outcome(seed) for seed in range(20_000, 20_040)]
    data = summary(outcomes)
    assert data['failures'] == {}
    assert '40 random rigs' in text(data)


def test_cases_are_valid_different_and_repeatable() -> None:
    first, again = case(3), case(3)
    assert first.configuration == again.configuration
    assert np.array_equal(first.voltages, again.voltages)
    rigs = [case(seed).configuration for seed in range(60)]
    assert {rig.model.friction.model for rig in rigs} == {0, 1, 2, 3}
    assert len({name for rig in rigs for name in rig.effects}) > 20


def test_a_wrong_balance_is_noticed() -> None:
    configuration, voltages = case(3)
    model = configuration.model
    nulls = {name: library.load(name).null for name in library.names()}
    plant = Plant(model, {**nulls, **configuration.effects})
    start = plant.state
    run = plant.run(np.repeat(voltages, 200, axis=0), 1e-3)
    good = residuals(run, start, model, configuration.effects)
    warmer = run._replace(pressure_1=run.pressure_1 * np.linspace(1.0, 1.3, run.time.size))
    assert residuals(warmer, start, model, configuration.effects).gas > 10.0 * good.gas
    assert problems(run._replace(pressure_2=-run.pressure_2), model)
    assert problems(run._replace(position=run.position + 20.0), model)
    assert problems(run._replace(velocity=np.full(run.time.size, np.nan)), model)
