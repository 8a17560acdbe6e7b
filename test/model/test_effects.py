"""Every effect of the library, by being there."""

import numpy as np
import pytest

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model import effects
from pneu_rig_ros.model.compiled_model import compiled_model
from pneu_rig_ros.model.effect import Signals
from pneu_rig_ros.model.plant import Plant
from pneu_rig_ros.model.quantity import Quantity, specifications

from .rigs import changed, stroke

REGIMES = {'dwell', 'presliding', 'breakaway', 'sliding', 'end stop'}
MODEL = changed('cylinder_2')


def null_effects() -> dict[str, object]:
    return {name: effects.load(name).null for name in effects.names()}


def test_null_values_reproduce_the_baseline_bit_for_bit() -> None:
    baseline = stroke(Plant(MODEL), 0.34, 5.0)
    nulled = stroke(Plant(MODEL, null_effects()), 0.34, 5.0)
    assert np.ptp(baseline.position) > 0.02
    for name, column in baseline._asdict().items():
        assert np.array_equal(column, getattr(nulled, name)), name


@pytest.mark.parametrize('name', effects.names())
def test_effect_changes_the_run(name: str) -> None:
    baseline = stroke(Plant(MODEL), 0.34, 3.0)
    parameters = {key: some_value(spec) for key, spec in quantities(name).items()}
    chosen = null_effects() | {name: effects.load(name).parameters(**parameters)}
    changed_run = stroke(Plant(MODEL, chosen), 0.34, 3.0)
    assert np.all(np.isfinite(changed_run.position))
    assert not np.array_equal(baseline.pressure_1, changed_run.pressure_1)


@pytest.mark.parametrize('name', effects.names())
def test_effect_describes_itself(name: str) -> None:
    effect = effects.load(name)
    assert effect.title
    assert effect.source
    assert effect.regimes
    assert set(effect.regimes) <= REGIMES
    for key, spec in quantities(name).items():
        assert spec.unit
        assert spec.description
        assert spec.low <= getattr(effect.null, key) <= spec.high


@pytest.mark.parametrize('name', effects.names())
def test_null_contribution_is_exactly_zero(name: str) -> None:
    effect = effects.load(name)
    signals = Signals(
        1.0, 0.1, 0.02, 2e5, 1.5e5, 1e-4, 2e-4, 2e-4, 3e-4, 2.8, 2.2, 5e5, 5e5, 1e-4, 5.0, False,
        3.0,
    )  # fmt: skip
    size = len(effect.states)
    rate = np.full(size, np.nan)
    pair = effect.contribution(signals, compiled_model(MODEL), effect.null, np.zeros(size), rate)
    assert tuple(pair) == (0.0, 0.0)
    assert np.array_equal(rate, np.zeros(size))


def test_unknown_effect_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(RigError, match="did you mean 'chamber_leak'"):
        Plant(MODEL, {'chamber_leek': ()})


def quantities(name: str) -> dict[str, Quantity]:
    specs = specifications(effects.load(name).parameters)
    return {key: spec for key, spec in specs.items() if isinstance(spec, Quantity)}


def some_value(spec: Quantity) -> float:
    return spec.low + 0.02 * (spec.high - spec.low)
