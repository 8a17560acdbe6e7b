"""
``python -m reliability.bag_watch BAG``: reads a bag that is being recorded, until told to stop.

Every few seconds the project's reader opens it and reads its last seconds. Each time that it has
doubled, mcap and rosbags read all of it too. A line of standard input ends it; it then prints what
it saw as JSON.
"""

import json
import os
import select
import sys
import time
from collections import Counter
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

from mcap.reader import make_reader
from rosbags.rosbag2 import Reader

from pneu_rig_ros.records.bag import open_bag, storage_files
from pneu_rig_ros.records.cdr import unpack_stamp

PERIOD = 2.0
"""Between two looks [s]."""

RECENT_NS = 3_000_000_000
"""How much of the end is read at each look [ns]."""


class Watch:
    """What was seen so far."""

    def __init__(self, bag: Path) -> None:
        self.bag = bag
        self.looks: Counter[str] = Counter()
        self.failures: list[str] = []
        self.messages = 0
        self.oldest = 0.0
        self._size = 0

    def look(self) -> None:
        """Read the bag by all readers whose turn it is."""
        self._read('pneu-rig', self._ours)
        size = storage_files(self.bag)[0].stat().st_size
        if size > 2 * self._size:
            self._size = size
            self._read('mcap', self._mcap)
            self._read('rosbags', self._rosbags)

    def _read(self, name: str, read: Callable[[], int]) -> None:
        self.looks[name] += 1
        known = self.messages
        try:
            count = read()
        except Exception as error:  # whatever a reader says: it could not read
            self.failures.append(f'{name}: {type(error).__name__} {error}')
            return
        if count < known:
            self.failures.append(f'{name}: {count} messages, {known} were there before')
        self.messages = max(known, count)

    def _ours(self) -> int:
        with open_bag(self.bag) as reader:
            samples = [c for c in reader.connections if c.topic == '/joint_states']
            end = reader.end_time
            self.oldest = max(self.oldest, (time.time_ns() - end) * 1e-9)
            recent = reader.messages(samples, start=end - RECENT_NS)
            stamps = [unpack_stamp(bytes(cdr)) for _, _, cdr in recent]
            if len({b - a for a, b in pairwise(stamps)}) != 1:
                raise ValueError('a sample is missing')
            return reader.message_count

    def _mcap(self) -> int:
        with storage_files(self.bag)[0].open('rb') as stream:
            messages = make_reader(stream, validate_crcs=True).iter_messages(log_time_order=False)
            return sum(1 for _ in messages)

    def _rosbags(self) -> int:
        with Reader(storage_files(self.bag)[0]) as reader:
            return sum(1 for _ in reader.messages())


def main() -> None:
    """Look until told to stop."""
    os.nice(19)
    watch = Watch(Path(sys.argv[1]))
    while not select.select([sys.stdin], [], [], PERIOD)[0]:
        watch.look()
    seen = {'looks': watch.looks, 'failures': watch.failures, 'oldest_s': watch.oldest}
    print(json.dumps(seen))


if __name__ == '__main__':
    main()
