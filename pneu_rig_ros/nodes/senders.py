"""Whether a topic has several senders at once, by the numbers that each gives its messages."""

import time
from collections import deque

MEMORY = 5.0
"""How long a change of sender is remembered [s]."""


class Senders:
    """
    Notes each message of a topic.

    A sender counts upwards. A step back is another sender, or the same one started anew; two of
    them within a few seconds are senders that alternate.
    """

    def __init__(self) -> None:
        self._last = 0
        self._steps_back: deque[float] = deque(maxlen=2)

    def note(self, number: int) -> None:
        """Note the number of the next message."""
        if number <= self._last:
            self._steps_back.append(time.monotonic())
        self._last = number

    @property
    def several(self) -> bool:
        """Whether more than one spoke within the last seconds."""
        return len(self._steps_back) == 2 and time.monotonic() - self._steps_back[0] < MEMORY
