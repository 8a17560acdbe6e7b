"""Every effect of the library, by being there."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model import effects
from pneu_rig_ros.model.compiled_model import (
    ChamberGas,
    Motion,
    Ports,
    Seal,
    Signals,
    compiled_model,
)
from pneu_rig_ros.model.effect import READING_BALANCES, Regime
from pneu_rig_ros.model.parameters import FRICTION_MODELS, Model
from pneu_rig_ros.model.plant import Plant, Trajectory
from pneu_rig_ros.model.quantity import Quantity, specifications

from .rigs import changed, stroke, with_effects

MODEL = changed('cylinder_2')
POSITION_NOISE, PRESSURE_NOISE = 29e-6, 165.0
"""Of the rig's sensors with their converter [m, Pa]."""


def there_and_back(plant: Plant) -> Trajectory:
    """Return two slow strokes over half of the cylinder, and a fast one over all of it."""
    runs = [stroke(plant, *each) for each in ((0.5, 8.0), (-0.5, 8.0), (1.2, 6.0))]
    return Trajectory(*(np.concatenate(columns) for columns in zip(*runs, strict=True)))


def test_null_values_reproduce_the_baseline_bit_for_bit() -> None:
    baseline = stroke(Plant(MODEL), 0.34, 5.0)
    nulled = stroke(Plant(MODEL, effects.nulls()), 0.34, 5.0)
    assert np.ptp(baseline.position) > 0.02
    for name, column in baseline._asdict().items():
        assert np.array_equal(column, getattr(nulled, name)), name


@pytest.mark.parametrize('name', effects.names())
def test_effect_changes_the_run(name: str) -> None:
    effect = effects.load(name)
    model = model_that_lacks(name)
    baseline = there_and_back(Plant(model, effects.nulls()))
    on_sensor = effect.balance in READING_BALANCES
    for probe in effect.probes:
        run = there_and_back(Plant(model, effects.nulls() | {name: probe}))
        assert (
            seen(baseline.position_reading - run.position_reading, POSITION_NOISE)
            or seen(baseline.pressure_1_reading - run.pressure_1_reading, PRESSURE_NOISE)
            or seen(baseline.pressure_2_reading - run.pressure_2_reading, PRESSURE_NOISE)
        )
        moved = baseline.position - run.position
        assert seen(moved, POSITION_NOISE) != on_sensor, probe


@pytest.mark.parametrize('name', [n for n in effects.names() if not effects.load(n).describes])
def test_effect_is_safe_at_its_bounds(name: str) -> None:
    """Also next to a bound that is zero, where a time constant or stiffness has no null."""
    ranges = [
        (spec.low if spec.low else 1e-9 * spec.high, spec.high)
        for spec in quantities(name).values()
    ]
    model = model_that_lacks(name)
    for values in itertools.product(*ranges):
        run = stroke(Plant(model, with_effects(**{name: values}), 1e-5), 0.5, 2.0)
        assert all(np.all(np.isfinite(column)) for column in run), values
        assert run.position.min() >= -1e-9
        assert run.position.max() <= model.cylinder.stroke + 1e-9


@pytest.mark.parametrize('name', effects.names())
def test_effect_describes_itself(name: str) -> None:
    effect = effects.load(name)
    assert effect.title
    assert effect.source
    assert effect.regimes
    assert set(effect.regimes) <= set(Regime)
    for key, spec in quantities(name).items():
        assert spec.unit
        assert spec.description
        for values in (effect.null, *effect.probes):
            assert spec.low <= getattr(values, key) <= spec.high
    assert 2 <= len(effect.probes) <= 12  # each is screened
    assert effect.null not in effect.probes
    defaults = effect.parameters._field_defaults
    simplest = [probe for probe in effect.probes if probe._replace(**defaults) == probe]
    assert simplest or effect.describes
    assert set(effect.laws) <= set(FRICTION_MODELS)
    assert set(effect.proportional) <= set(effect.parameters._fields)


@pytest.mark.parametrize(
    'regimes', [(), ('dwell',), (0, 1), (Regime.DWELL, Regime.DWELL), (Regime.DWELL, 'sliding')]
)
def test_effect_with_other_regimes_is_refused(regimes: tuple[object, ...]) -> None:
    with pytest.raises(RigError, match=r'regimes .*, must be some of Regime\.DWELL, Regime\.PRE'):
        replace(effects.load('stribeck'), regimes=regimes)


def test_regimes_are_named_for_people() -> None:
    names = [regime.label for regime in Regime]
    assert names == ['dwell', 'presliding', 'breakaway', 'sliding', 'end stop']


@pytest.mark.parametrize('name', effects.names())
def test_null_contribution_is_exactly_zero(name: str) -> None:
    effect = effects.load(name)
    signals = Signals(
        time=1.0,
        motion=Motion(0.1, 0.02),
        gas=ChamberGas(2e5, 1.5e5, 1e-4, 2e-4, 2e-4, 3e-4),
        ports=Ports(2.8, 2.2, 5e5, 5e5),
        seal=Seal(1e-4, 5.0, False, 3.0, 6.0, 15.0),
    )
    size = len(effect.states)
    rate = np.full(size, np.nan)
    states = (np.zeros(size), rate) if effect.takes_states else ()
    pair = effect.contribution(signals, compiled_model(MODEL), effect.null, *states)
    assert tuple(pair) == (0.0, 0.0)
    assert np.array_equal(rate, np.zeros(size))


def test_parameters_of_another_effect_are_refused() -> None:
    wrong = effects.load('inclination').parameters(0.1)
    with pytest.raises(
        RigError, match=r'effects\.chamber_leak: .*angle=0\.1.* no parameters of it'
    ):
        Plant(MODEL, {'chamber_leak': wrong, 'inclination': wrong})


def test_unknown_effect_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(RigError, match="did you mean 'chamber_leak'"):
        Plant(MODEL, {'chamber_leek': ()})


def quantities(name: str) -> dict[str, Quantity]:
    specs = specifications(effects.load(name).parameters)
    return {key: spec for key, spec in specs.items() if isinstance(spec, Quantity)}


def model_that_lacks(name: str) -> Model:
    laws = effects.load(name).laws or FRICTION_MODELS
    return changed('cylinder_2', friction={'model': FRICTION_MODELS.index(laws[-1])})


def seen(difference: NDArray[np.float64], noise: float) -> bool:
    assert np.all(np.isfinite(difference))
    return bool(np.abs(difference).max() > 3.0 * noise)
