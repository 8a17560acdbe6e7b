"""Rate, jitter and losses follow from stamps and arrivals; the summary is plain data."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.analysis.friction import friction_of
from pneu_rig_ros.analysis.summary import lost_samples, summarise
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import Recording, read_recording
from pneu_rig_ros.records.recording import NEVER, WHOLE
from pneu_rig_ros.rig import Rig, load_configuration
from pneu_rig_ros.rig.valve_drive import valve_voltages
from pneu_rig_ros.simulate import simulate


@pytest.fixture(scope='module')
def record(bag: Path) -> Recording:
    return read_recording(bag)


def test_live_and_offline_friction_agree(record: Recording) -> None:
    live = record.friction[25:-25]
    offline = friction_of(record)[25:-25]
    assert np.abs(live - offline).max() < 0.5


def test_estimated_friction_is_the_friction_of_the_plant(record: Recording) -> None:
    rig = Rig(load_configuration('cylinder_2'))
    rig.reset()
    truth = [rig.state.friction_force]
    for _ in range(record.position.size - 1):
        rig.step(*valve_voltages(0.34))
        truth.append(rig.state.friction_force)
    error = friction_of(record) - np.array(truth)
    # 1 % of pressure, 0.5 % of position, one sensor step of 73 um: see the rig's sensors.
    assert np.median(np.abs(error)) < 0.5
    assert summarise(record).peak_friction == pytest.approx(max(truth), rel=0.03)


def test_simulated_time_has_the_exact_rate_and_no_jitter(record: Recording) -> None:
    summary = summarise(record)
    assert summary.rate == pytest.approx(1e9 / 1_160_000)
    assert summary.jitter_p50 == summary.jitter_p99 == 0.0
    assert set(summary.lost.values()) == {0}


def test_jitter_is_measured_from_the_median_delay(record: Recording) -> None:
    arrival = record.arrival_ns + 5_000_000
    arrival[::50] += 3_000_000
    summary = summarise(replace(record, arrival_ns=arrival))
    assert summary.jitter_p50 == 0.0
    assert summary.jitter_p99 == pytest.approx(3e-3)


def test_missing_samples_do_not_change_the_rate(record: Recording) -> None:
    arrival = record.arrival_ns.copy()
    arrival[100:200] = NEVER
    summary = summarise(replace(record, arrival_ns=arrival))
    assert summary.rate == pytest.approx(1e9 / 1_160_000)


def test_losses_are_counted_by_topic(record: Recording) -> None:
    friction = record.friction.copy()
    friction[[100, 101]] = np.nan
    missing = {**record.missing, 'joint_states': record.stamps[[3, 4, 5]]}
    counts = {**record.counts, 'velocity': record.counts['velocity'] - 7}
    lossy = replace(record, missing=missing, counts=counts).with_signals(friction=friction)
    assert lost_samples(lossy) == {
        'joint_states': 3,
        'chamber_1/pressure': 0,
        'chamber_2/pressure': 0,
        'friction': 2,
        'position': 0,
        'velocity': 7,
    }


def test_friction_estimator_that_died_is_seen(record: Recording) -> None:
    friction = record.friction.copy()
    friction[1000:] = np.nan
    assert lost_samples(record.with_signals(friction=friction))['friction'] == friction.size - 1025


def test_summary_is_plain_json(record: Recording) -> None:
    data = json.loads(json.dumps(summarise(record).to_dict(), allow_nan=False))
    assert data['cylinder'] == 'cylinder_2'
    assert data['samples'] == 2587
    assert data['cycle_count'] == len(data['cycles']) >= 1
    assert data['lost']['joint_states'] == 0


def test_record_without_configuration_has_a_summary_but_no_friction(record: Recording) -> None:
    anonymous = replace(record, configuration=None)
    summary = summarise(anonymous)
    assert summary.peak_friction is None
    assert len(summary.cycles) == len(summarise(record).cycles) > 0
    json.dumps(summary.to_dict(), allow_nan=False)
    with pytest.raises(RigError, match='does not hold the configuration'):
        friction_of(anonymous)


def test_samples_too_far_apart_for_eq_2_have_a_summary_but_no_friction(record: Recording) -> None:
    signals = {name: record[name][::18] for name in WHOLE}
    slow = Recording(
        'slow', 0, 18 * record.interval_ns, signals, configuration=record.configuration
    )
    assert summarise(slow).peak_friction is None
    with pytest.raises(RigError, match='too slow for the 32 Hz filter'):
        friction_of(slow)


def test_shortest_possible_bag_has_a_summary(tmp_path: Path) -> None:
    bag = simulate(load_configuration('cylinder_1'), 0.0, 1e-6, tmp_path / 'bag')
    summary = summarise(read_recording(bag))
    assert summary.samples == 1
    assert math.isnan(summary.rate)
    assert summary.to_dict()['rate'] is None
    assert summary.cycles == ()


def test_part_of_a_rig_has_no_summary(record: Recording) -> None:
    part = replace(record, signals={'position': record.position}, name='part')
    with pytest.raises(RigError, match='part: no pressure_1 in it; it has position'):
        summarise(part)
