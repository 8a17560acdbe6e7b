"""Lost messages, from the numbers that publishers give theirs."""

SHARED = frozenset({'u', '/diagnostics'})
"""Topics with several publishers, whose numbers interleave."""


class Losses:
    """Counts the gaps in the numbers of each topic that has one publisher."""

    def __init__(self) -> None:
        self.total = 0
        self._last: dict[str, int] = {}

    def note(self, topic: str, number: int) -> None:
        """Note the number of the next message of a topic; a restarted publisher begins anew."""
        last = self._last.get(topic, number)
        if number > last + 1 and topic not in SHARED:
            self.total += number - last - 1
        self._last[topic] = number
