"""When a message without a stamp was sent, in simulated time."""

from bisect import bisect_right


class Timeline:
    """
    Maps sending times to simulated time.

    Each sample marks its stamp at the moment when it was sent. What was sent after it and before
    the next one happened at its stamp: this follows from cause and effect alone, so that two runs
    in lock step agree, however late the messages were read.
    """

    def __init__(self) -> None:
        self._sent: list[int] = []
        self._stamps: list[int] = []

    def mark(self, sent_ns: int, stamp_ns: int) -> None:
        """Note that the sample of `stamp_ns` was sent at `sent_ns`, after all noted before."""
        self._sent.append(sent_ns)
        self._stamps.append(stamp_ns)

    def knows(self, sent_ns: int) -> bool:
        """Return whether a sample sent later is known, so that the time asked for is final."""
        return bool(self._sent) and sent_ns <= self._sent[-1]

    def time_of(self, sent_ns: int) -> int:
        """Return the stamp of the newest sample sent before [ns]; 0 before the first one."""
        index = bisect_right(self._sent, sent_ns)
        return self._stamps[index - 1] if index else 0

    def forget_before(self, sent_ns: int) -> None:
        """Drop the marks that no message sent after `sent_ns` needs."""
        keep = max(bisect_right(self._sent, sent_ns) - 1, 0)
        del self._sent[:keep], self._stamps[:keep]
