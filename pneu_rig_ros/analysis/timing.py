"""How well a recording kept time: achieved rate, jitter of the arrivals, lost samples."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pneu_rig_ros.analysis.friction import delay_samples
from pneu_rig_ros.records import Recording
from pneu_rig_ros.records.recording import NEVER

PLAIN = ('position', 'velocity')
"""Topics sent with each sample that carry no stamp: their messages can only be counted."""


class Timing(NamedTuple):
    """
    Arrival of the samples at the recorder.

    :param rate: samples a second [Hz], by the times at which they arrived
    :param jitter_p50: median of the jitter [s]
    :param jitter_p99: its 99th percentile [s]
    :param lost: topic -> samples that are not in the bag
    """

    rate: float
    jitter_p50: float
    jitter_p99: float
    lost: dict[str, int]


def measure_timing(recording: Recording) -> Timing:
    """
    Return the timing of a recording.

    The delay of a sample is its arrival less its stamp; jitter is how far a delay lies from the
    median delay. NaN where a recording is too short to say.
    """
    index = np.flatnonzero(recording.arrival_ns != NEVER)
    arrival = recording.arrival_ns[index]
    span = (arrival[-1] - arrival[0]) * 1e-9 if index.size > 1 else 0.0
    rate = (index[-1] - index[0]) / span if span > 0 else float('nan')
    delay = (arrival - recording.stamps[index]).astype(np.float64)
    jitter = np.abs(delay - np.median(delay)) * 1e-9
    p50, p99 = np.percentile(jitter, [50, 99])
    return Timing(float(rate), float(p50), float(p99), lost_samples(recording))


def lost_samples(recording: Recording) -> dict[str, int]:
    """
    Return topic -> number of samples that are not in the bag.

    By stamp where there is one. The live friction estimate cannot cover the first and the last
    samples, as many as it is late; they are not lost.
    """
    lost = {topic: int(stamps.size) for topic, stamps in recording.missing.items()}
    if 'friction' in recording.missing:
        margin = delay_samples(recording.interval)
        gaps = np.isnan(recording.friction[margin : max(margin, recording.friction.size - margin)])
        lost['friction'] = int(gaps.sum())
    for topic in PLAIN:
        if topic in recording.counts:
            lost[topic] = max(0, recording.position.size - recording.counts[topic])
    return lost
