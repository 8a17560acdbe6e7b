"""Many messages are decoded at once, and as each of them is."""

from collections.abc import Sequence

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.cdr_decoding import (
    Decoder,
    decode_all,
    unpack_float64,
    unpack_joint_state,
    unpack_valve_voltages,
)
from pneu_rig_ros.records.cdr_encoding import pack_float64, pack_valve_voltages

STORE = get_typestore(Stores.ROS2_JAZZY)
JOINT = 'sensor_msgs/msg/JointState'


def joint_state(time: float, *position: float, frame: str = 'base', effort: bool = True) -> bytes:
    types = STORE.types
    stamp = types['builtin_interfaces/msg/Time'](sec=int(time), nanosec=int(time % 1 * 1e9))
    header = types['std_msgs/msg/Header'](stamp=stamp, frame_id=frame)
    values = np.array(position)
    message = types[JOINT](
        header=header,
        name=['piston', 'other'][: len(position)],
        position=values,
        velocity=2.0 * values,
        effort=-values if effort else np.empty(0),
    )
    return bytes(STORE.serialize_cdr(message, JOINT))


def one_by_one(decoder: Decoder, messages: Sequence[bytes]) -> np.ndarray:
    rows = [decoder(message) for message in messages]
    return np.array([row if isinstance(row, tuple) else (0, row) for row in rows])


@pytest.mark.parametrize('effort', [True, False])
def test_messages_of_any_layout_are_decoded_as_each_is(effort: bool) -> None:
    random = np.random.default_rng(1)
    messages = [
        joint_state(
            1e3 + 0.25 * k,
            *random.normal(size=1 + k % 3 // 2),
            frame='base' + 'x' * (k % 5 == 4),
            effort=effort,
        )
        for k in range(40)
    ]
    stamps, values = decode_all(unpack_joint_state, messages)
    rows = one_by_one(unpack_joint_state, messages)
    np.testing.assert_array_equal(stamps, rows[:, 0].astype(np.int64))
    np.testing.assert_array_equal(values, rows[:, 1:])


def test_numbers_without_a_stamp_are_decoded() -> None:
    stamps, values = decode_all(unpack_float64, [pack_float64(0.1 * k) for k in range(5)])
    np.testing.assert_array_equal(stamps, 0)
    np.testing.assert_array_equal(values[:, 0], 0.1 * np.arange(5))
    _, values = decode_all(unpack_valve_voltages, [pack_valve_voltages(1.0, k) for k in range(3)])
    np.testing.assert_array_equal(values, [(1.0, 0.0), (1.0, 1.0), (1.0, 2.0)])


@pytest.mark.parametrize('damage', [slice(8, 12), slice(12, 16)])  # stamp, length of the frame
def test_damaged_message_is_named_by_its_number(damage: slice) -> None:
    messages = [joint_state(k, 0.5) for k in range(4)]
    bad = bytearray(messages[2])
    bad[damage] = b'\xff\xff\xff\xff'
    with pytest.raises(RigError, match='message 3: '):
        decode_all(unpack_joint_state, [*messages[:2], bytes(bad), messages[3]])


def test_first_message_that_is_damaged_is_named() -> None:
    with pytest.raises(RigError, match='message 1: '):
        decode_all(unpack_float64, [b'\x00\x01\x00\x00', pack_float64(1.0)])
