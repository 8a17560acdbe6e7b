"""A few kB in a bag cannot fill the memory."""

import bz2
import struct
from pathlib import Path

import lz4.frame
import pytest
from backports import zstd
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_typestore

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import read_recording
from pneu_rig_ros.records.mcap_file import LARGEST_CHUNK, decompress

COMPRESSORS = {'zstd': zstd.compress, 'lz4': lz4.frame.compress, 'bz2': bz2.compress}
MAPPING = {'topics': {'position': {'topic': '/x', 'field': 'data'}}}


@pytest.mark.parametrize('name', COMPRESSORS)
def test_content_of_the_size_that_it_claims_is_returned(name: str) -> None:
    parts = b'a' * 5000, bytes(range(256))
    data = b''.join(map(COMPRESSORS[name], parts))  # two frames
    assert decompress(data, name, 5256) == b''.join(parts)
    assert decompress(b'abc', '', 3) == b'abc'


@pytest.mark.parametrize('name', COMPRESSORS)
@pytest.mark.parametrize('claimed', [0, 100, 2**27 + 1])
def test_content_of_another_size_is_refused(name: str, claimed: int) -> None:
    with pytest.raises(RigError, match=f'does not have the {claimed} bytes'):
        decompress(COMPRESSORS[name](bytes(1000)), name, claimed)
    assert claimed <= LARGEST_CHUNK + 1


def test_cut_content_and_other_compressions_are_refused() -> None:
    with pytest.raises(RigError, match='does not have the 1000 bytes'):
        decompress(zstd.compress(bytes(1000))[:-3], 'zstd', 1000)
    with pytest.raises(RigError, match="'brotli', allowed: zstd, lz4"):
        decompress(b'', 'brotli', 1)


@pytest.mark.parametrize('format_', list(Writer.CompressionFormat))
def test_chunk_of_a_ros_1_bag_has_the_size_that_it_claims(
    tmp_path: Path, format_: Writer.CompressionFormat
) -> None:
    store, path = get_typestore(Stores.ROS1_NOETIC), tmp_path / 'a.bag'
    made = Writer(path)
    made.set_compression(format_)
    with made:
        connection = made.add_connection('/x', 'std_msgs/msg/Float64', typestore=store)
        for k in range(20):
            made.write(connection, 1 + k * 10**6, struct.pack('<d', 0.1 * k))
    assert read_recording(path, MAPPING).size == 20
    data = bytearray(path.read_bytes())
    struct.pack_into('<I', data, data.index(b'size=') + 5, 50)
    path.write_bytes(data)
    with pytest.raises(RigError, match='does not have the 50 bytes'):
        read_recording(path, MAPPING)
