"""Where a model disagrees: in the right balance, and nowhere where it does not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.inputs.prepare_runs import prepare_run
from pneu_rig_ros.diagnosis.residuals.localisation import SignificantResidual, localise
from pneu_rig_ros.diagnosis.residuals.whitening import whitener
from pneu_rig_ros.diagnosis.residuals.windows import Windows, windows_of
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.rig import RigConfiguration

from .runs import TIMELINE, Timeline, changed, configured, data_of, measured, recorded, system_of

LEAK = 3e-9
SEEDS = 50


def white(balance: str, recording: str, size: int, rng: np.random.Generator) -> Windows:
    """Return windows of white noise, in three regimes and at random places."""
    kept = np.ones(size, dtype=np.bool_)
    noise = rng.standard_normal(size)
    regimes = np.array(['dwell', 'sliding', 'sliding'])[rng.integers(0, 3, size)]
    directions = np.where(regimes == 'dwell', '', rng.choice(['in', 'out'], size))
    variables = {
        'position': rng.uniform(0.0, 0.3, size),
        'velocity': rng.uniform(-0.2, 0.2, size),
        'pressure_1': rng.uniform(1e5, 6e5, size),
        'pressure_2': rng.uniform(1e5, 6e5, size),
        'dwell': np.where(regimes == 'dwell', rng.uniform(0.1, 9.0, size), np.nan),
    }
    start = 0.05 * np.arange(size)
    return Windows(
        balance,
        recording,
        start,
        start + 0.1,
        regimes,
        directions,
        variables,
        noise,
        noise,
        whitener(kept, [], np.ones(size)),
        np.ones(size),
    )


def noisy(seed: int) -> list[Windows]:
    rng = np.random.default_rng(seed)
    return [
        white(balance, name, 200, rng) for balance in ('gas_1', 'gas_2', 'force') for name in 'ab'
    ]


def test_white_noise_is_rarely_significant() -> None:
    significant = sum(bool(localise(noisy(seed))) for seed in range(SEEDS))
    assert significant <= 4


def test_strong_residual_of_one_regime_makes_no_other_significant() -> None:
    """The false-discovery rate is that of regimes, however many cells of one are significant."""
    false = []
    for seed in range(SEEDS):
        # as large as the noise may be, so that the tests have the size that they state
        groups = [replace(one, whitened=1.1 * one.whitened) for one in noisy(seed)]
        shifted = [
            replace(one, whitened=one.whitened + 2.0 * (one.balance == 'gas_1')) for one in groups
        ]
        found = localise(shifted)
        wrong = sum(residual.balance != 'gas_1' for residual in found)
        false.append(wrong / len(found))
        assert wrong < len(found)
    assert np.mean(false) <= 0.08


@pytest.mark.filterwarnings('ignore:overflow')
def test_residual_that_overflows_is_significant_and_no_error() -> None:
    """Of a start that is far off."""
    groups = [replace(one, whitened=one.whitened + 1e160) for one in noisy(0)]
    assert {one.balance for one in localise(groups)} == {'gas_1', 'gas_2', 'force'}


def test_a_shift_of_one_noise_is_found_with_its_size_and_bounds() -> None:
    groups = noisy(0)
    shifted = []
    for one in groups:
        shift = 1.0 * ((one.balance == 'gas_2') & (one.variables['position'] > 0.15))
        shifted.append(replace(one, whitened=one.whitened + shift, residual=one.residual + shift))
    first, *others = localise(shifted)
    assert first.balance == 'gas_2'
    assert {one.balance for one in others} <= {'gas_2'}
    # the noise decides whether the whole regime, of which half is shifted, is more significant
    expected = 1.0 if first.variable == 'position' else 0.5
    assert first.mean == pytest.approx(expected, abs=3.0 * first.noise)
    places = [low for variable, low, _ in first.parts if variable == 'position']
    assert places
    assert min(places) > 0.1


def test_a_shift_after_long_rests_is_found_with_the_dwell() -> None:
    shifted = []
    for one in noisy(1):
        long = np.nan_to_num(one.variables['dwell']) > 6.0
        shift = 2.0 * ((one.balance == 'gas_1') & long)
        shifted.append(replace(one, whitened=one.whitened + shift, residual=one.residual + shift))
    first = localise(shifted)[0]
    assert (first.balance, first.regime, first.variable) == ('gas_1', 'dwell', 'dwell')
    assert first.low is not None
    assert first.low > 3.0
    assert ('dwell', first.low, first.high) in first.parts


def test_dwell_is_the_rest_before_a_breakaway_and_none_while_it_moves(tmp_path: Path) -> None:
    system = system_of(tmp_path, configured('cylinder_1'))
    run = measured(system, 'run', configured('cylinder_1'))
    data = data_of(system.hypothesis, run)
    groups = windows_of(data, system.hypothesis)
    (breaks,) = (one for one in groups if set(one.regime) == {'breakaway'})
    for moment, dwell in zip(breaks.middle, breaks.variables['dwell'], strict=True):
        rest = min(run.rests, key=lambda each: abs(each.end * run.interval - moment))
        before = run.operation.rest_time if rest.first == 0 else 0.0
        lasted = before + (rest.end - rest.first) * run.interval
        assert dwell == pytest.approx(lasted, abs=0.01)
    (gas,) = (one for one in groups if one.balance == 'gas_1')
    assert np.isnan(gas.variables['dwell'][gas.regime == 'sliding']).all()
    assert np.isfinite(gas.variables['dwell'][gas.regime == 'dwell']).any()


def located(
    folder: Path,
    change: RigConfiguration,
    given: RigConfiguration | None = None,
    timeline: Timeline = TIMELINE,
) -> list[SignificantResidual]:
    """Return where a model disagrees with two runs of a rig; without a change if none is given."""
    system = system_of(folder, given or configured('cylinder_1'))
    runs = [measured(system, f'run_{i}', replace(change, seed=i), timeline) for i in (1, 2)]
    dataset = data_of(system.hypothesis, *runs)
    return localise(windows_of(dataset, system.hypothesis))


@pytest.mark.parametrize('cylinder', ['cylinder_1', 'cylinder_3'])
def test_nothing_is_significant_of_a_true_model(tmp_path: Path, cylinder: str) -> None:
    assert located(tmp_path, configured(cylinder), configured(cylinder)) == []


@pytest.mark.parametrize(('area', 'balance'), [('area_1', 'gas_1'), ('area_2', 'gas_2')])
def test_leak_is_found_in_its_chamber_alone(tmp_path: Path, area: str, balance: str) -> None:
    leak = library.load('chamber_leak').null._replace(**{area: LEAK})
    found = located(tmp_path, configured('cylinder_1', {'chamber_leak': leak}))
    assert {one.balance for one in found} == {balance}
    assert found[0].significance > 6.0
    assert found[0].mean < 0.0  # it lacks an outflow
    assert found[0].unit == 'kg/s'


PAIR: Timeline = ((0.45, 0.5), (0.0, 1.0), (0.45, 0.5), (0.0, 3.0))
RESTS: Timeline = (*PAIR, *PAIR, *PAIR, (0.45, 0.5))
"""A timeline with rests of 0.7 s and of 2.8 s."""


def growing(exponent: float) -> RigConfiguration:
    """Return a rig whose static friction grows with a power of the dwell, anew after each slip."""
    rig = configured('cylinder_1')
    return changed(rig, 'friction', dwell_exponent=exponent, memory_time=0.1)


def test_static_friction_of_long_rests_is_found_with_the_dwell(tmp_path: Path) -> None:
    # with either exponent it is the same after 1 s: 0.2 N apart after 0.7 s, 1.4 N after 2.8 s
    given = growing(0.45)
    found = located(tmp_path, growing(0.9), given, RESTS)
    (breaks,) = (one for one in found if (one.balance, one.regime) == ('force', 'breakaway'))
    (low,) = (low for name, low, _ in breaks.parts if name == 'dwell')
    assert low == pytest.approx(2.8, abs=0.1)
    assert breaks.mean > 0.0
    assert located(tmp_path, given, given, RESTS) == []


def test_less_friction_is_found_in_the_force_in_both_directions(tmp_path: Path) -> None:
    rig = configured('cylinder_1')
    less = 0.8 * rig.model.friction.coulomb_force
    found = located(tmp_path, changed(rig, 'friction', coulomb_force=less))
    assert {one.balance for one in found} == {'force'}
    signs = {one.direction: np.sign(one.mean) for one in found if one.regime == 'sliding'}
    assert signs == {'out': 1.0, 'in': -1.0}
    assert min(one.p_value for one in found) < 1e-9


@pytest.mark.parametrize(('short', 'found'), [(0.0, False), (1e-3, True)])
def test_reading_that_falls_short_of_an_end_stop_is_found_with_its_place(
    short: float, found: bool, tmp_path: Path
) -> None:
    rig = configured('cylinder_2', initial_position=0.15)
    system, stroke = system_of(tmp_path, rig), rig.model.cylinder.stroke
    recording = recorded('stop', rig, ((0.6, 8.0),))
    read = recording.signals['position']
    recording.signals['position'] = np.where(read > stroke - short, stroke - short, read)
    run = prepare_run(recording, system, Path('stop'))
    data = data_of(system.hypothesis, run)
    significant = [
        each for each in localise(windows_of(data, system.hypothesis)) if each.unit == 'm'
    ]
    assert bool(significant) == found
    for each in significant:
        assert (each.balance, each.regime) == ('force', 'end stop')
        assert each.mean == pytest.approx(-short, abs=1e-4)
