"""Metrics with known answers, noise against its formula, and runs simulated once more."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.analysis.comparison import (
    command_onset,
    estimate_shift,
    resample_overlap,
    simulate_record,
)
from pneu_rig_ros.analysis.friction import ForceBalance, friction_zero_phase
from pneu_rig_ros.analysis.metrics import (
    SignalGap,
    analyse_run,
    compare_signals,
    derived_signals,
    signal_noise,
    stroke_time,
)
from pneu_rig_ros.analysis.velocity import WINDOW
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import Recording, read_recording
from pneu_rig_ros.records.recording import WHOLE
from pneu_rig_ros.rig import RigConfiguration, load_configuration
from pneu_rig_ros.rig.sensors import sensor_noise
from pneu_rig_ros.simulate import simulate

INTERVAL = 1.16e-3
BALANCE = ForceBalance(1.3e-3, 1.1e-3, 0.65, 1e5)


@pytest.fixture(scope='module')
def ideal() -> RigConfiguration:
    return load_configuration('cylinder_2', sensors='ideal')


@pytest.fixture(scope='module')
def record(ideal: RigConfiguration, tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return read_recording(simulate(ideal, 0.34, 8.0, tmp_path_factory.mktemp('runs') / 'ideal'))


def test_metrics_are_those_of_the_differences() -> None:
    measured = {'position': np.zeros(4), 'pressure_1': np.ones(4), 'elsewhere': np.ones(9)}
    simulated = {'position': np.array([1.0, -1.0, 1.0, -5.0]), 'pressure_1': np.full(4, 3.0)}
    gaps = compare_signals(measured, simulated, {'position': 0.5})
    assert set(gaps) == {'position', 'pressure_1'}
    gap = gaps['position']
    assert gap.unit == 'm'
    assert gap.rmse == pytest.approx(np.sqrt(7.0))
    assert gap.largest == 5.0
    assert gap.bias == -1.0
    assert gap.multiple == pytest.approx(2.0 * np.sqrt(7.0))
    assert gap.above_noise == pytest.approx(np.sqrt(6.75))
    assert gaps['pressure_1'].multiple is None
    assert gaps['pressure_1'].bias == 2.0


def test_what_cannot_be_compared_is_said() -> None:
    with pytest.raises(RigError, match='a: 3 samples, at least 4 are needed'):
        analyse_run(Recording('a', 0, 1_160_000, dict.fromkeys(WHOLE, np.zeros(3))))
    with pytest.raises(RigError, match='a: no pressure_2 in it'):
        analyse_run(Recording('a', 0, 1_160_000, dict.fromkeys(WHOLE[:2], np.zeros(5))))


def test_noise_of_derived_signals() -> None:
    noise = signal_noise(2e-5, 0.0, INTERVAL, BALANCE)
    samples = 2 * round(WINDOW / INTERVAL / 2) + 1
    assert noise['velocity'] == pytest.approx(2e-5 / INTERVAL * np.sqrt(12 / samples**3), rel=0.1)
    assert noise['position'] == 2e-5
    pressures = signal_noise(0.0, 100.0, INTERVAL, BALANCE)['friction']
    assert pressures == pytest.approx(100.0 * np.hypot(1.3e-3, 1.1e-3), rel=0.05)
    assert 'friction' not in signal_noise(2e-5, 100.0, INTERVAL)


def gaps_between(
    measured: Recording, simulated: Recording, noise: dict[str, float]
) -> dict[str, SignalGap]:
    return compare_signals(analyse_run(measured).signals, analyse_run(simulated).signals, noise)


def test_model_that_made_a_run_repeats_it(ideal: RigConfiguration, record: Recording) -> None:
    measured, again = analyse_run(record), analyse_run(simulate_record(record, ideal))
    gaps = compare_signals(measured.signals, again.signals, {})
    # the initial position is a mean of readings, so the run starts some nanometres off
    assert gaps['position'].rmse < 5e-6
    assert gaps['position'].largest < 7.3e-5  # a step of the rig's sensor: a slip comes at once
    assert gaps['pressure_1'].rmse < 20.0
    assert gaps['friction'].rmse < 0.05
    dwells = [cycle.dwell for cycle in measured.cycles]
    assert [cycle.dwell for cycle in again.cycles] == pytest.approx(dwells, abs=3e-3)
    assert len(measured.cycles) > 2


@pytest.mark.parametrize(('sensors', 'vented'), [('rig', True), ('ideal', False)])
def test_noise_of_a_vented_chamber_is_no_pressure(
    record: Recording, sensors: str, vented: bool
) -> None:
    configuration = load_configuration('cylinder_2', sensors=sensors)
    zero = configuration.model.gas.atmospheric_pressure
    read = record.pressure_2.copy()
    read[0] = zero + sensor_noise(configuration.sensors)[1]
    noisy = replace(
        record, configuration=configuration, signals={**record.signals, 'pressure_2': read}
    )
    start = simulate_record(noisy, configuration).pressure_2[0]
    assert start == (zero if vented else read[0])


def test_pressure_below_the_atmosphere_is_where_a_simulation_starts(record: Recording) -> None:
    configuration = load_configuration('cylinder_2')
    read = np.full(record.size, 0.8 * configuration.model.gas.atmospheric_pressure)
    drawn = replace(
        record, configuration=configuration, signals={**record.signals, 'pressure_2': read}
    )
    assert simulate_record(drawn, configuration).pressure_2[0] == read[0]


def test_another_model_shows(ideal: RigConfiguration, record: Recording) -> None:
    other = load_configuration('cylinder_2', friction='coulomb_viscous')
    noise = signal_noise(*sensor_noise(ideal.sensors), record.interval, ForceBalance.of(ideal))
    gap = gaps_between(record, simulate_record(record, other), noise)['position']
    assert gap.multiple is not None
    assert gap.multiple > 10.0


def test_noise_is_what_the_sensors_show(tmp_path: Path) -> None:
    configuration = load_configuration('cylinder_2')
    still = read_recording(simulate(configuration, 0.0, 2.0, tmp_path / 'still'))
    pressure = sensor_noise(configuration.sensors)[1]
    assert np.std(still.pressure_1) == pytest.approx(pressure, rel=0.6)


@pytest.mark.parametrize(
    ('start', 'end', 'reached'),
    [(0.0, 0.3, 0.98), (0.3, 0.0, 0.98), (0.0, 0.2, None), (0.1, 0.3, 0.97)],
)
def test_stroke_time(start: float, end: float, reached: float | None) -> None:
    position = np.linspace(start, end, 1001)
    time = stroke_time(position, 1e-3, 0.3)
    assert time is None if reached is None else time == pytest.approx(reached, abs=2e-3)
    assert stroke_time(position, 1e-3, None) is None


def later(record: Recording, samples: int) -> Recording:
    """Return the record with its first sample held for so many samples more."""
    volts = ('voltage_1', 'voltage_2')
    signals = {name: np.pad(record[name], (samples, 0), mode='edge') for name in WHOLE}
    signals |= {name: np.concatenate([np.full(samples, 2.5), record[name]]) for name in volts}
    return Recording('late', 0, record.interval_ns, signals, configuration=record.configuration)


def test_records_are_aligned_by_their_command(record: Recording) -> None:
    late = later(record, 500)
    assert command_onset(record) == 0.0
    assert estimate_shift(record, late) == pytest.approx(500 * record.interval)
    first, second = resample_overlap(record, late, estimate_shift(record, late))
    np.testing.assert_allclose(first.position, second.position, atol=1e-12)
    assert first.position.size == record.position.size
    earlier, cut = resample_overlap(late, record, -500 * record.interval)
    np.testing.assert_allclose(earlier.pressure_1, cut.pressure_1, atol=1e-6)
    assert cut.position.size == record.position.size


def test_records_that_do_not_overlap(record: Recording) -> None:
    with pytest.raises(RigError, match='ideal and ideal do not overlap'):
        resample_overlap(record, record, 60.0)


def test_slow_sampling_leaves_friction_out() -> None:
    still = np.zeros(100)
    assert 'friction' in derived_signals(still, still, still, 0.01, BALANCE)
    assert 'friction' not in derived_signals(still, still, still, 0.02, BALANCE)
    with pytest.raises(RigError, match='a sample every 20 ms is too slow for the 32 Hz filter'):
        friction_zero_phase(still, still, still, 0.02, BALANCE)
