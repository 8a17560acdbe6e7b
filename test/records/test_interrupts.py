"""An interrupt while a chunk is written: it waits, and the bag is whole."""

import os
import signal
from pathlib import Path

import pytest

from pneu_rig_ros.records import BagWriter
from pneu_rig_ros.records.bag import check_bag, open_bag


def test_interrupt_within_a_write_leaves_a_whole_bag(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write = os.pwrite

    def interrupted(descriptor: int, data: bytes, offset: int) -> int:
        done = write(descriptor, data, offset)
        signal.raise_signal(signal.SIGINT)
        return done

    writer = BagWriter(tmp_path / 'bag')
    writer.write('/u', 'std_msgs/msg/Float64', 0, bytes(12))
    monkeypatch.setattr(os, 'pwrite', interrupted)
    with pytest.raises(KeyboardInterrupt):
        writer.flush()
    monkeypatch.undo()
    writer.write('/u', 'std_msgs/msg/Float64', 1, bytes(12))
    writer.close({})
    check_bag(tmp_path / 'bag')
    with open_bag(tmp_path / 'bag') as bag:
        assert bag.message_count == 2
