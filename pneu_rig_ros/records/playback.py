"""The messages of a bag in the order in which they were sent, for playback."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

from pneu_rig_ros.errors import RigError, prefixed
from pneu_rig_ros.records.bag import Bag, Connection, find_namespace, open_bag, reading
from pneu_rig_ros.records.topics import CLOCK, DERIVED, DIAGNOSTICS, TOPICS, absolute_names

COMPUTED = {'friction', DIAGNOSTICS, CLOCK} | {t for t in TOPICS if t.startswith(DERIVED)}
"""Topics that nodes compute from the others; they are not played by default."""

_FIRST = (
    *(topic.name for topic in TOPICS.values() if topic.transient_local),
    CLOCK,
    *('joint_states', 'position', 'velocity', 'chamber_1/pressure', 'chamber_2/pressure'),
    *('reference', 'u', 'valve_voltages'),
)
ORDER = (*_FIRST, *(topic for topic in TOPICS if topic not in _FIRST))
"""Causes before effects: descriptions, then samples, then the responses to them."""


class Message(NamedTuple):
    """One message: log time [ns], topic of the table, bytes."""

    time_ns: int
    topic: str
    cdr: bytes


class Playback:
    """
    A bag that is open for playback. Use as a context manager or call ``close``.

    :param path: the bag's directory, or a file in it
    :param only: topics to play, relative; default: those of the rig that are not computed
    :param without: topics not to play
    :raises RigError: when it is not a complete bag of a rig, or lacks a requested topic
    """

    topics: list[str]
    """Names of the topics that are played, relative to the rig's namespace."""
    start_ns: int
    """Log time of the first message in the bag [ns]."""
    duration: float
    """Time from the first to the last message in the bag [s]."""

    def __init__(
        self, path: Path | str, only: Iterable[str] = (), without: Iterable[str] = ()
    ) -> None:
        self._opened = open_bag(path)
        self._bag = self._opened.__enter__()
        try:
            with prefixed(path):
                played = _chosen(self._bag, set(only), set(without))
        except RigError:
            self.close()
            raise
        self.topics = list(played)
        self._names = {connection: topic for topic, connection in played.items()}
        self.start_ns = self._bag.start_time
        self.duration = (self._bag.end_time - self.start_ns) * 1e-9

    def __enter__(self) -> Playback:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the bag."""
        self._opened.__exit__(None, None, None)

    def messages(self) -> Iterator[Message]:
        """
        Yield the messages; of those logged at the same time, the sample comes first.

        :raises RigError: when the bag is damaged
        """
        found = (
            Message(time_ns, self._names[connection], cdr)
            for connection, time_ns, cdr in self._bag.messages(self._names)
        )
        with reading(self._bag.directory):
            for _, together in groupby(found, key=lambda message: message.time_ns):
                yield from sorted(together, key=lambda message: ORDER.index(message.topic))


def _chosen(bag: Bag, only: set[str], without: set[str]) -> dict[str, Connection]:
    """Return topic -> connection of what is to be played."""
    namespace = find_namespace(c.topic for c in bag.connections)
    present = {c.topic: c for c in bag.connections if c.msgcount}
    names = absolute_names(namespace).items()
    known = {t: present[name] for t, name in names if name in present}
    for topic in (only | without) - set(TOPICS):
        raise RigError(f'{topic} is not a topic of a rig, allowed: {", ".join(TOPICS)}')
    for topic in only - set(known):
        raise RigError(f'the bag has no message on {topic}, it has {", ".join(known)}')
    wanted = (only or set(known) - COMPUTED) - without
    chosen = {t: c for t, c in known.items() if t in wanted}
    if not chosen:
        raise RigError('no topic is left to play')
    return chosen
