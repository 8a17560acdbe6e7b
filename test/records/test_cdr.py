"""The encoders against two independent ones: rosbags' typestore and rclpy."""

import math
import struct

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import cdr_decoding, cdr_encoding
from pneu_rig_ros.records.cdr_encoding import PlantMessages
from pneu_rig_ros.records.topics import CLOCK, TOPICS
from pneu_rig_ros.rig import Sample

STORE = get_typestore(Stores.ROS2_JAZZY)
VALUES = (0.0, -0.0, 1.0, -0.34, math.pi, 1e-300, -1e300, math.inf)
STAMPS = (0, 1_160_000, 999_999_999, 1_000_000_000, 1_753_000_000_123_456_789)


def serialize(type_name, **fields):
    return bytes(STORE.serialize_cdr(STORE.types[type_name](**fields), type_name))


def time(stamp_ns):
    seconds, nanoseconds = divmod(stamp_ns, 10**9)
    return STORE.types['builtin_interfaces/msg/Time'](sec=seconds, nanosec=nanoseconds)


def header(stamp_ns, frame_id=''):
    return STORE.types['std_msgs/msg/Header'](stamp=time(stamp_ns), frame_id=frame_id)


def joint_state(stamp_ns, position=(), velocity=(), effort=(), frame_id='', names=('piston',)):
    return serialize(
        'sensor_msgs/msg/JointState',
        header=header(stamp_ns, frame_id),
        name=list(names),
        position=np.array(position, dtype=float),
        velocity=np.array(velocity, dtype=float),
        effort=np.array(effort, dtype=float),
    )


@pytest.mark.parametrize('prefix', ['', 'rig/', 'lab/left/'])
@pytest.mark.parametrize('stamp_ns', STAMPS)
@pytest.mark.parametrize('value', VALUES)
def test_plant_messages_equal_the_typestore(value, stamp_ns, prefix):
    sample = Sample(7, value, -value, 6e5 + 1, value)
    messages = PlantMessages(2.5, prefix, clock=True).pack(sample, stamp_ns)
    stamped = {'header': header(stamp_ns, f'{prefix}cylinder'), 'variance': 2.5}
    frame_id = f'{prefix}base'
    pressure = 'sensor_msgs/msg/FluidPressure'
    assert messages == {
        'joint_states': joint_state(stamp_ns, [value], [-value], frame_id=frame_id),
        'position': serialize('std_msgs/msg/Float64', data=value),
        'velocity': serialize('std_msgs/msg/Float64', data=-value),
        'chamber_1/pressure': serialize(pressure, fluid_pressure=6e5 + 1, **stamped),
        'chamber_2/pressure': serialize(pressure, fluid_pressure=value, **stamped),
        CLOCK: serialize('rosgraph_msgs/msg/Clock', clock=time(stamp_ns)),
    }
    assert CLOCK not in PlantMessages(2.5).pack(sample, stamp_ns)


@pytest.mark.parametrize('stamp_ns', STAMPS)
@pytest.mark.parametrize('value', VALUES)
def test_friction_equals_the_typestore(value, stamp_ns):
    packed = cdr_encoding.template('friction').at(stamp_ns, value)
    assert packed == joint_state(stamp_ns, effort=[value], frame_id='base')
    reading = cdr_decoding.unpack_joint_state(packed)
    assert (reading.stamp_ns, reading.effort) == (stamp_ns, value)
    assert all(map(math.isnan, (reading.position, reading.velocity)))


def test_an_earlier_message_is_not_changed_by_a_later_one():
    messages = PlantMessages(1.0)
    before = messages.pack(Sample(0, 1.0, 2.0, 3.0, 4.0), 1)['joint_states']
    messages.pack(Sample(1, 5.0, 6.0, 7.0, 8.0), 2)
    assert cdr_decoding.unpack_joint_state(before)[:3] == (1, 1.0, 2.0)


@pytest.mark.parametrize('value', VALUES)
def test_plain_messages_round_trip(value):
    assert cdr_decoding.unpack_float64(cdr_encoding.pack_float64(value)) == value
    assert cdr_decoding.unpack_valve_voltages(cdr_encoding.pack_valve_voltages(value, 2.5)) == (
        value,
        2.5,
    )


@pytest.mark.parametrize('text', ['', 'a', 'name: cylinder_2  # 1 µm\n'])
def test_string_round_trip(text):
    assert cdr_encoding.pack_string(text) == serialize('std_msgs/msg/String', data=text)
    assert cdr_decoding.unpack_string(cdr_encoding.pack_string(text)) == text


@pytest.mark.parametrize('frame_id', ['', 'a', 'ab', 'abc', 'abcd', 'abcdefgh'])
@pytest.mark.parametrize('names', [(), ('x',), ('piston', 'load'), ('ab', 'abc', 'abcd')])
def test_joint_states_of_others_are_read(frame_id, names):
    message = joint_state(5, [1.0, 2.0], [3.0], [4.0, 5.0, 6.0], frame_id, names)
    assert cdr_decoding.unpack_joint_state(message) == (5, 1.0, 3.0, 4.0)
    assert cdr_decoding.unpack_stamp(message) == 5


@pytest.mark.parametrize('other', ['x', 'xy', 'xyz', 'elbow'])
def test_a_command_is_that_of_the_piston(other):
    message = joint_state(5, [], [1.0, 2.0], [], '', (other, 'piston'))
    assert cdr_decoding.unpack_joint_command(message)[::2] == (5, 2.0)
    for wrong in (
        joint_state(5, [], [1.0], [], '', names) for names in ((other, 'piston'), (other,))
    ):
        with pytest.raises(RigError, match=r'joint'):
            cdr_decoding.unpack_joint_command(wrong)


@pytest.mark.parametrize('frame_id', ['', 'a', 'ab', 'abc', 'abcd', 'abcdefgh'])
def test_pressures_of_others_are_read(frame_id):
    fields = {'header': header(6, frame_id), 'fluid_pressure': 1.0, 'variance': 2.0}
    message = serialize('sensor_msgs/msg/FluidPressure', **fields)
    assert cdr_decoding.unpack_fluid_pressure(message) == (6, 1.0, 2.0)


def voltages(labels, data):
    dimension = STORE.types['std_msgs/msg/MultiArrayDimension']
    layout = STORE.types['std_msgs/msg/MultiArrayLayout'](
        dim=[dimension(label=label, size=2, stride=2) for label in labels], data_offset=0
    )
    name = 'std_msgs/msg/Float64MultiArray'
    return serialize(name, layout=layout, data=np.array(data, dtype=float))


@pytest.mark.parametrize('labels', [(), ('',), ('valve',), ('a', 'bc')])
def test_voltages_with_any_layout_are_read(labels):
    assert cdr_decoding.unpack_valve_voltages(voltages(labels, [1.0, 2.0])) == (1.0, 2.0)


@pytest.mark.parametrize('data', [[], [1.0], [1.0, 2.0, 3.0]])
def test_other_than_two_voltages_are_refused(data):
    with pytest.raises(RigError, match=f'{len(data)} values, allowed 2'):
        cdr_decoding.unpack_valve_voltages(voltages(('v',), data))


@pytest.mark.parametrize(
    ('unpack', 'cdr'),
    [
        (cdr_decoding.unpack_float64, cdr_encoding.pack_float64(1.0)),
        (cdr_decoding.unpack_valve_voltages, cdr_encoding.pack_valve_voltages(1.0, 2.0)),
        (cdr_decoding.unpack_joint_state, cdr_encoding.template('friction').at(2, 1.0)),
        (cdr_decoding.unpack_string, cdr_encoding.pack_string('abcdefg')),
    ],
)
def test_cut_messages_are_refused(unpack, cdr):
    for length in range(len(cdr)):
        with pytest.raises(RigError, match=r'too few|does not end|not little-endian'):
            unpack(cdr[:length])


def test_big_endian_is_refused():
    with pytest.raises(RigError, match='little-endian'):
        cdr_decoding.unpack_float64(b'\x00\x00\x00\x00' + struct.pack('>d', 1.0))


def test_rclpy_reads_every_message_back():
    serialization = pytest.importorskip('rclpy.serialization')
    from rosgraph_msgs.msg import Clock
    from sensor_msgs.msg import FluidPressure, JointState
    from std_msgs.msg import Float64, Float64MultiArray

    sample = Sample(0, 0.1, -0.2, 6e5, 1e5)
    messages = PlantMessages(2.5, clock=True).pack(sample, STAMPS[-1])
    read = serialization.deserialize_message
    joint = read(messages['joint_states'], JointState)
    assert (list(joint.name), list(joint.position), list(joint.velocity)) == (
        ['piston'],
        [0.1],
        [-0.2],
    )
    assert list(joint.effort) == []
    assert joint.header.stamp.sec * 10**9 + joint.header.stamp.nanosec == STAMPS[-1]
    pressure = read(messages['chamber_1/pressure'], FluidPressure)
    assert (pressure.fluid_pressure, pressure.variance) == (6e5, 2.5)
    assert read(messages['position'], Float64).data == 0.1
    assert read(messages[CLOCK], Clock).clock.nanosec == STAMPS[-1] % 10**9
    voltage = read(cdr_encoding.pack_valve_voltages(1.5, 3.5), Float64MultiArray)
    assert list(voltage.data) == [1.5, 3.5]
    assert voltage.layout.dim[0].size == 2
    assert list(read(cdr_encoding.template('friction').at(1, 9.0), JointState).effort) == [9.0]


def test_what_rclpy_writes_is_read():
    serialize_message = pytest.importorskip('rclpy.serialization').serialize_message
    from sensor_msgs.msg import FluidPressure, JointState
    from std_msgs.msg import Float64, Float64MultiArray

    joint = JointState(name=['piston'], position=[1.0], velocity=[2.0], effort=[3.0])
    assert cdr_decoding.unpack_joint_state(serialize_message(joint)) == (0, 1.0, 2.0, 3.0)
    pressure = FluidPressure(fluid_pressure=4.0, variance=5.0)
    assert cdr_decoding.unpack_fluid_pressure(serialize_message(pressure)) == (0, 4.0, 5.0)
    assert serialize_message(Float64(data=0.34)) == cdr_encoding.pack_float64(0.34)
    both = Float64MultiArray(data=[1.0, 2.0])
    assert cdr_decoding.unpack_valve_voltages(serialize_message(both)) == (1.0, 2.0)


def test_the_table_names_known_types():
    assert all(topic.type in STORE.types for topic in TOPICS.values())
    assert all(name == topic.name for name, topic in TOPICS.items())
