"""That what a witness received is in a bag, message by message."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.nodes.diagnostics import PROCESS_KEY
from pneu_rig_ros.records import Recording
from pneu_rig_ros.records.bag import open_bag
from pneu_rig_ros.records.cdr import typestore
from pneu_rig_ros.records.recording import Stamps
from pneu_rig_ros.records.topics import DIAGNOSTICS, TOPICS
from reliability.witness import Received

LAST_WORDS_NS, LATE_NS = 1_000_000_000, 100_000_000
"""Before and after the death of a sender [ns]."""

Numbers = NDArray[np.int64]

RUN = 20
"""How many messages in a row tell a place: one value alone may repeat."""


def messages(bag: Path) -> dict[str, list[bytes]]:
    """Return the messages of each stream of a bag, in their order."""
    found: dict[str, list[bytes]] = defaultdict(list)
    with open_bag(bag) as reader:
        for connection, _, cdr in reader.messages():
            name = connection.topic.lstrip('/')
            topic = name if name in TOPICS else connection.topic
            stream, content = told(topic, bytes(cdr))
            found[stream].append(content)
    return found


def told(topic: str, cdr: bytes) -> tuple[str, bytes]:
    """
    Return the stream of a message and its content.

    The stream is the topic; of /diagnostics, to which all publish, that of one process. There the
    bytes between two fields are whatever was in memory, and not those that another process gets.
    """
    if topic != DIAGNOSTICS:
        return topic, cdr
    kind = TOPICS[topic].type
    message: Any = typestore().deserialize_cdr(cdr, kind)
    (status,) = message.status
    process = next(item.value for item in status.values if item.key == PROCESS_KEY)
    content = bytes(typestore().serialize_cdr(message, kind))
    return f'{topic} of {status.name}, {process}', content


def missing_samples(record: Recording) -> int:
    """
    Return how many messages of the sampled topics a record lacks.

    At its very ends there is no friction, as the filter has to look to both sides; and a bag that
    is being recorded may end within a sample.
    """
    return sum(_inside(record, missing) for missing in record.missing.values())


def _inside(record: Recording, missing: Stamps) -> int:
    """Count the missing stamps [ns] of a topic between its first and its last one."""
    present = np.setdiff1d(record.stamps, missing, assume_unique=True)
    return int(((missing > present[0]) & (missing < present[-1])).sum())


def unproven(
    received: dict[str, list[Received]],
    bag: dict[str, list[bytes]],
    until_ns: int,
    deaths_ns: Sequence[int] = (),
) -> dict[str, int]:
    """
    Return how many messages are missing from a bag, by topic, of those that miss some.

    :param received: by the witness, who may have begun before or after the recorder
    :param until_ns: up to when what was received has to be in the bag [ns since 1970]
    :param deaths_ns: when senders were killed, who may have told the witness what they told
        nobody else in their last second [ns since 1970]
    """
    streams: dict[str, list[Received]] = defaultdict(list)
    for topic, found in received.items():
        for message in found:
            if message.time_ns <= until_ns:
                stream, content = told(topic, message.cdr)
                streams[stream].append(Received(message.time_ns, content))
    counts = {
        name: sum(not _last_words(m, deaths_ns) for m in _missing(wanted, bag.get(name, [])))
        for name, wanted in streams.items()
    }
    return {topic: count for topic, count in counts.items() if count}


def _last_words(message: Received, deaths_ns: Sequence[int]) -> bool:
    return any(death - LAST_WORDS_NS <= message.time_ns <= death + LATE_NS for death in deaths_ns)


def _missing(wanted: list[Received], kept: list[bytes]) -> list[Received]:
    """Return what is missing, in order; what came before the recorder had begun is not asked."""
    numbers: dict[bytes, int] = {}
    have = np.array([numbers.setdefault(cdr, len(numbers)) for cdr in kept], dtype=np.int64)
    want = np.array([numbers.setdefault(m.cdr, len(numbers)) for m in wanted], dtype=np.int64)
    begins = ((k, _find(want[k : k + RUN], have, 0)) for k in range(want.size))
    first, place = next(((k, p) for k, p in begins if p is not None), (want.size, None))
    if place is None:
        return [] if want.size <= RUN else wanted
    missing = []
    for index in range(first, want.size):
        if place < have.size and have[place] == want[index]:
            place += 1
            continue
        found = _find(want[index : index + RUN], have, place)
        if found is None:
            missing.append(wanted[index])
        else:
            place = found + 1
    return missing


def _find(run: Numbers, have: Numbers, start: int) -> int | None:
    """Return where a message and the next few are from a place on; values may repeat."""
    places = np.arange(start, have.size - run.size + 1)
    for offset, number in enumerate(run):
        places = places[have[places + offset] == number]
    return int(places[0]) if places.size else None
