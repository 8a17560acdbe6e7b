"""That what a witness received is in a bag, message by message."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pneu_rig_ros.records import Record
from pneu_rig_ros.records.bag import open_bag
from pneu_rig_ros.records.topics import DIAGNOSTICS, TOPICS
from reliability.witness import Received

SHARED = {DIAGNOSTICS}
"""Topics whose messages come from several publishers, in an order that is each listener's own."""


def messages(bag: Path) -> dict[str, list[bytes]]:
    """Return the messages of each topic of a bag, in their order."""
    found: dict[str, list[bytes]] = defaultdict(list)
    with open_bag(bag) as reader:
        for connection, _, cdr in reader.messages():
            name = connection.topic.lstrip('/')
            found[name if name in TOPICS else connection.topic].append(bytes(cdr))
    return found


def missing_samples(record: Record) -> int:
    """
    Return how many messages of the sampled topics a record lacks.

    At its very ends there is no friction: the filter has to look to both sides.
    """
    known = np.flatnonzero(~np.isnan(record.friction))
    inside = record.stamps[known[0]], record.stamps[known[-1]]
    friction = record.missing['friction']
    within = (friction > inside[0]) & (friction < inside[1])
    others = [stamps.size for topic, stamps in record.missing.items() if topic != 'friction']
    return sum(others) + int(within.sum())


def unproven(
    received: dict[str, list[Received]], bag: dict[str, list[bytes]], until_ns: int
) -> dict[str, int]:
    """
    Return how many messages of each topic are missing from a bag.

    :param received: by the witness, who may have begun before or after the recorder
    :param until_ns: up to when what was received has to be in the bag [ns since 1970]
    """
    return {
        topic: _missing([m.cdr for m in found if m.time_ns <= until_ns], bag[topic], topic)
        for topic, found in received.items()
    }


def _missing(wanted: Sequence[bytes], kept: Sequence[bytes], topic: str) -> int:
    if topic in SHARED or TOPICS[topic].latched:
        # the recorder may have begun later: what it cannot have heard is not asked for
        begin = next((k for k, cdr in enumerate(wanted) if cdr in kept), len(wanted))
        return (Counter(wanted[begin:]) - Counter(kept)).total()
    if not wanted or not kept:
        return len(wanted)
    fewest = len(wanted)
    # Either begins somewhere in the other; a value may repeat, so that every place is tried.
    for start in (k for k, cdr in enumerate(wanted) if cdr == kept[0]):
        fewest = min(fewest, _different(wanted[start:], kept))
    for start in (k for k, cdr in enumerate(kept) if cdr == wanted[0]):
        fewest = min(fewest, _different(wanted, kept[start:]))
    return fewest


def _different(wanted: Sequence[bytes], kept: Sequence[bytes]) -> int:
    """Count the messages from the first difference on, 0 if `kept` begins with `wanted`."""
    for index, cdr in enumerate(wanted):
        if index >= len(kept) or kept[index] != cdr:
            return len(wanted) - index
    return 0
