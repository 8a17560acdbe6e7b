"""
An MCAP file that is complete at every moment while it grows.

After each piece stands the end of an MCAP file without an index, and the next piece overwrites it
in one call. A file that is still being recorded, or whose recorder was killed, is therefore read
by every MCAP reader.
"""

from __future__ import annotations

import os
from pathlib import Path

from mcap.data_stream import RecordBuilder
from mcap.records import DataEnd, Footer, McapRecord

MAGIC = b'\x89MCAP0\r\n'


def encode(*records: McapRecord) -> bytes:
    """Return records as they are in a file."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())


ENDING = encode(DataEnd(0), Footer(0, 0, 0)) + MAGIC
"""End of the data section, footer without a summary, magic."""


class GrowingFile:
    """
    A file to append to.

    :param path: the file to create
    """

    def __init__(self, path: Path) -> None:
        self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o644)
        self._size = 0
        self.closed = False

    def append(self, piece: bytes, ending: bytes = ENDING) -> None:
        """
        Hand data to the operating system: they survive the end of this process.

        :param ending: what follows them until the next call
        :raises OSError: e.g. when the disk is full; the file is then as before
        """
        data = piece + ending
        try:
            done = 0
            while done < len(data):
                done += os.pwrite(self._descriptor, data[done:], self._size + done)
        except OSError:
            # The blocks of the previous ending are still allocated, so this needs no space.
            os.ftruncate(self._descriptor, self._size + len(ENDING))
            os.pwrite(self._descriptor, ENDING, self._size)
            raise
        self._size += len(piece)

    def close(self) -> None:
        """Close the file."""
        if not self.closed:
            self.closed = True
            os.close(self._descriptor)
