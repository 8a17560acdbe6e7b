"""What the sequence numbers of messages show: losses, and several publishers of one topic."""

import time
from collections import deque

SHARED_TOPICS = frozenset({'u', '/diagnostics'})
"""Topics that may have several publishers, whose sequence numbers interleave."""

ALTERNATION_TIME = 5.0
"""Two decreases of the sequence number within this time show several publishers [s]."""

MOST_PUBLISHERS = 4
"""Publishers of one topic whose sequence numbers are followed, the latest ones."""


class LossCounter:
    """
    Counts lost messages by gaps in the sequence numbers of topics that should have one publisher.

    A number below the last one begins another publisher, or the same one after a restart; each
    number belongs to the publisher whose last one it follows most closely.
    """

    def __init__(self) -> None:
        self.total = 0
        self._last: dict[str, deque[int]] = {}

    def resume(self) -> None:
        """Begin again after a pause, in which no message was expected."""
        self._last.clear()

    def add(self, topic_name: str, sequence_number: int) -> None:
        """Add the next message of a topic."""
        if topic_name in SHARED_TOPICS:
            return
        publishers = self._last.setdefault(topic_name, deque(maxlen=MOST_PUBLISHERS))
        before = max((last for last in publishers if last < sequence_number), default=None)
        if before is not None:
            self.total += sequence_number - before - 1
            publishers.remove(before)
        publishers.append(sequence_number)


class PublisherConflict:
    """
    Detects several publishers of one topic by their sequence numbers.

    Each publisher counts upwards. A decrease is another publisher, or the same one after a
    restart; two decreases within a few seconds are publishers that alternate.
    """

    def __init__(self) -> None:
        self._last = 0
        self._decreases: deque[float] = deque(maxlen=2)

    def add(self, sequence_number: int) -> None:
        """Add the next message of the topic."""
        if sequence_number <= self._last:
            self._decreases.append(time.monotonic())
        self._last = sequence_number

    @property
    def detected(self) -> bool:
        """Whether several publishers have alternated within the last seconds."""
        decreases = self._decreases
        return len(decreases) == 2 and time.monotonic() - decreases[0] < ALTERNATION_TIME
