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
from mcap.records import DataEnd, Footer

MAGIC = b'\x89MCAP0\r\n'


def _ending() -> bytes:
    builder = RecordBuilder()
    DataEnd(data_section_crc=0).write(builder)
    Footer(summary_start=0, summary_offset_start=0, summary_crc=0).write(builder)
    return bytes(builder.end()) + MAGIC


ENDING = _ending()
"""End of the data section, footer without a summary, magic."""


class GrowingFile:
    """
    The output stream of an `mcap.writer.Writer`; data are buffered until `flush`.

    :param path: the file to create
    """

    def __init__(self, path: Path) -> None:
        self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o644)
        self._size = 0
        self.closed = False
        self._pending = bytearray()

    def write(self, data: bytes) -> int:
        """Append to the buffer."""
        self._pending += data
        return len(data)

    def tell(self) -> int:
        """Return the offset of the next byte."""
        return self._size + len(self._pending)

    def flush(self, ending: bytes = ENDING) -> None:
        """
        Hand the buffer to the operating system: it survives the end of this process.

        :param ending: what follows the data until the next flush
        :raises OSError: e.g. when the disk is full; the buffer is lost, the file is as before
        """
        if not self._pending and ending is ENDING:
            return
        piece = bytes(self._pending)
        self._pending.clear()
        try:
            self._put(piece + ending)
        except OSError:
            # The blocks of the previous ending are still allocated, so this needs no space.
            os.ftruncate(self._descriptor, self._size + len(ENDING))
            os.pwrite(self._descriptor, ENDING, self._size)
            raise
        self._size += len(piece)

    def close(self) -> None:
        """Close the file; what was not flushed is lost."""
        if not self.closed:
            self.closed = True
            os.close(self._descriptor)

    def _put(self, data: bytes) -> None:
        done = 0
        while done < len(data):
            done += os.pwrite(self._descriptor, data[done:], self._size + done)
