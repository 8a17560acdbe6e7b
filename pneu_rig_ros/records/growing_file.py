"""MCAP files that every reader can read while they grow, also after a kill."""

import contextlib
import os
import signal
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from zlib import crc32

from mcap.data_stream import RecordBuilder
from mcap.records import DataEnd, Footer, McapRecord
from mcap.summary import Summary

from pneu_rig_ros.records.mcap_file import MAGIC


def encode(*records: McapRecord) -> bytes:
    """Return records as they are in a file."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())


_ENDING = encode(DataEnd(0), Footer(0, 0, 0)) + MAGIC
"""End of the data section, footer without a summary, magic."""


class GrowingFile:
    """
    An MCAP file that is complete at every moment while it grows.

    After each piece stands the end of an MCAP file without an index, and the next piece overwrites
    it in one call. A file that is still being recorded, or whose recorder was killed, is therefore
    read by every MCAP reader.

    :ivar size: of the pieces, without the end that follows them [byte]
    """

    def __init__(self, path: Path) -> None:
        self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o644)
        self.size = 0
        self.closed = False

    def append(self, piece: bytes, ending: bytes = _ENDING) -> None:
        """
        Hand data to the operating system: they survive the end of this process.

        :param ending: what follows them until the next call
        :raises OSError: e.g. when the disk is full; the file is then as before
        """
        data = piece + ending
        try:
            done = 0
            while done < len(data):
                done += os.pwrite(self._descriptor, data[done:], self.size + done)
        except OSError:
            # The blocks of the previous ending are still allocated, so this needs no space.
            os.ftruncate(self._descriptor, self.size + len(_ENDING))
            os.pwrite(self._descriptor, _ENDING, self.size)
            raise
        self.size += len(piece)

    def close(self) -> None:
        """Close the file."""
        if not self.closed:
            self.closed = True
            os.close(self._descriptor)


@contextlib.contextmanager
def deferred_interrupts() -> Iterator[None]:
    """Let SIGINT and SIGTERM wait until a chunk is whole; their Python handlers run at the end."""
    if threading.current_thread() is not threading.main_thread():
        yield  # Python runs handlers in the main thread alone
        return
    present = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    handlers = {number: handler for number, handler in present.items() if callable(handler)}
    pending: list[int] = []
    for number in handlers:
        signal.signal(number, lambda received, _: pending.append(received))
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        if pending:
            signal.raise_signal(pending[0])


def index_bytes(summary: Summary, end: int) -> bytes:
    """Return what follows the data section of a file that ends at an offset: its index."""
    assert summary.statistics is not None
    statistics = replace(
        summary.statistics,
        channel_count=len(summary.channels),
        metadata_count=len(summary.metadata_indexes),
        schema_count=len(summary.schemas),
    )
    records: list[McapRecord] = [*summary.schemas.values(), *summary.channels.values()]
    records += [statistics, *summary.chunk_indexes, *summary.metadata_indexes]
    data_end, content = encode(DataEnd(0)), encode(*records)
    start = end + len(data_end)
    # The checksum covers the summary and the footer up to the checksum itself.
    checksum = crc32(content + encode(Footer(start, 0, 0))[:-4])
    return data_end + content + encode(Footer(start, 0, checksum)) + MAGIC
