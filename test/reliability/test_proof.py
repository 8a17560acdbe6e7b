"""The proof that messages are in a bag: it misses none, and none that is there."""

import struct

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.serialization import serialize_message

from pneu_rig_ros.nodes.diagnostics import PROCESS_KEY
from reliability.proof import told, unproven
from reliability.witness import Received


def received(values: list[float]) -> dict[str, list[Received]]:
    return {'position': [Received(k, packed(value)) for k, value in enumerate(values)]}


def packed(value: float) -> bytes:
    return struct.pack('<d', value)


def test_values_that_repeat_for_seconds_are_found_where_they_are() -> None:
    stroke = [0.1 * k for k in range(300)]
    kept = {'position': [packed(value) for value in [0.0] * 90_000 + stroke]}
    assert unproven(received([0.0] * 50 + stroke), kept, 10**9) == {}


def test_what_is_missing_is_counted() -> None:
    stroke = [0.1 * k for k in range(300)]
    kept = {'position': [packed(value) for value in stroke[:100] + stroke[107:]]}
    assert unproven(received(stroke), kept, 10**9) == {'position': 7}
    assert unproven(received(stroke), {}, 10**9) == {'position': 300}
    assert unproven(received(stroke), kept, 99) == {}


def test_bytes_between_fields_do_not_count() -> None:
    status = DiagnosticStatus(name='/plant', values=[KeyValue(key=PROCESS_KEY, value='7@rig')])
    cdr = serialize_message(DiagnosticArray(status=[status]))
    other = bytearray(cdr)
    other[4 + 13 : 4 + 16] = b'xyz'  # behind the empty frame_id
    stream, content = told('/diagnostics', bytes(cdr))
    assert stream == '/diagnostics of /plant, 7@rig'
    assert told('/diagnostics', bytes(other)) == (stream, content)
