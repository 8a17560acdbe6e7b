"""Messages that are made many at a time are those that are made one by one."""

from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.cdr_encoding import (
    PlantMessages,
    pack_float64,
    pack_valve_voltages,
    template,
)
from pneu_rig_ros.records.conversion import BLOCK, write_bag
from pneu_rig_ros.records.mcap_file import McapFile
from pneu_rig_ros.records.recording import Recording
from pneu_rig_ros.rig import Sample

COUNT = BLOCK + 7
START, INTERVAL = 1_700_000_000_999_000_000, 1_160_000
SIGNALS = ('position', 'velocity', 'pressure_1', 'pressure_2', 'u', 'voltage_1', 'voltage_2')
LOST = {'position': (3, BLOCK, BLOCK + 6), 'pressure_2': (0,), 'u': (3,)}


def recording() -> Recording:
    random = np.random.default_rng(3)
    signals = {name: random.uniform(1.0, 4.0, COUNT) for name in (*SIGNALS, 'force', 'friction')}
    signals['friction'][:40] = np.nan
    missing = {name: START + INTERVAL * np.array(lost) for name, lost in LOST.items()}
    return Recording('here', START, INTERVAL, signals, missing)


def one_by_one(made: Recording) -> list[tuple[str, int, bytes]]:
    """Return topic, stamp and message of everything, in order."""
    plant, force, messages = PlantMessages(0.0), template('friction'), []
    for k, stamp in enumerate(made.stamps.tolist()):
        values = {name: float(signal[k]) for name, signal in made.signals.items()}
        sample = Sample(k, *(values[name] for name in SIGNALS[:4]))
        by_topic = {
            'u': pack_float64(values['u']),
            'valve_voltages': pack_valve_voltages(values['voltage_1'], values['voltage_2']),
            **plant.pack(sample, stamp),
            'force': force.at(stamp, values['force']),
            'friction': force.at(stamp, values['friction']),
        }
        if k in LOST['position']:
            for topic in ('joint_states', 'position', 'velocity'):
                del by_topic[topic]
        if k in LOST['pressure_2']:
            del by_topic['chamber_2/pressure']
        if k in LOST['u']:
            del by_topic['u'], by_topic['valve_voltages']
        if np.isnan(values['friction']):
            del by_topic['friction']
        messages += [(f'/{topic}', stamp, cdr) for topic, cdr in by_topic.items()]
    return messages


def test_bag_holds_the_messages_in_their_order(tmp_path: Path) -> None:
    made = recording()
    write_bag(made, tmp_path / 'bag')
    with (tmp_path / 'bag' / 'bag.mcap').open('rb') as stream:
        file = McapFile(stream)
        topics = {number: channel.topic for number, channel in file.summary.channels.items()}
        read = [(topics[channel], stamp, cdr) for stamp, channel, cdr in file.messages(topics)]
        assert file.protected()
    expected = one_by_one(made)
    assert [row[:2] for row in read] == [row[:2] for row in expected]
    assert read == expected


def test_index_of_the_bag_finds_each_message(tmp_path: Path) -> None:
    """`mcap` itself, which follows the index of a chunk."""
    reader = pytest.importorskip('mcap.reader')
    made = recording()
    write_bag(made, tmp_path / 'bag')
    with (tmp_path / 'bag' / 'bag.mcap').open('rb') as stream:
        found = [
            message.data
            for _, channel, message in reader.make_reader(stream).iter_messages(['/friction'])
            if channel.topic == '/friction'
        ]
    assert found == [cdr for topic, _, cdr in one_by_one(made) if topic == '/friction']


def test_a_stamp_that_no_message_can_hold_is_refused(tmp_path: Path) -> None:
    signals = {'position': np.zeros(3)}
    with pytest.raises(RigError, match='2038'):
        write_bag(Recording('late', 2**31 * 10**9, 10**9, signals), tmp_path / 'bag')
