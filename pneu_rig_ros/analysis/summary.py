"""A recording in a few numbers: rig, timing, losses, travel and stick-slip cycles."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from pneu_rig_ros.analysis.friction import delay_samples, known_friction
from pneu_rig_ros.analysis.motion import Cycle, cycles_of
from pneu_rig_ros.records import Recording
from pneu_rig_ros.records.recording import NEVER, WHOLE

PLAIN = ('position', 'velocity')
"""Topics sent with each sample that carry no stamp: their messages can only be counted."""


@dataclass(frozen=True)
class Summary:
    """
    The numbers of one recording, SI units; texts of the rig are 'unknown' if the bag has none.

    :param source: file that the recording was imported from, None of a plant's
    :param samples: on the sampling grid
    :param travel: largest less smallest position [m]
    :param peak_friction: largest breakaway friction [N], None without cycles or configuration
    :param rate: samples a second [Hz], by the times at which they arrived
    :param jitter_p50: median of the jitter [s], see ``measure_timing``; then its 99th percentile
    :param lost: topic -> samples that are not in the bag
    """

    cylinder: str
    friction_model: str
    seed: str
    source: str | None
    duration: float
    samples: int
    interval: float
    travel: float
    peak_friction: float | None
    cycles: tuple[Cycle, ...]
    rate: float
    jitter_p50: float
    jitter_p99: float
    lost: dict[str, int]

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON; numbers that are not known are None."""
        cycles = [cycle.to_dict() for cycle in self.cycles]
        data = {**vars(self), 'cycles': cycles, 'cycle_count': len(cycles)}
        return {key: None if value != value else value for key, value in data.items()}


def summarise(recording: Recording) -> Summary:
    """Return the summary of a recording; RigError when it is that of a part of a rig."""
    for name in WHOLE:
        recording[name]  # RigError without it
    friction = known_friction(recording)
    cycles = cycles_of(recording, friction)
    rate, jitter_p50, jitter_p99 = measure_timing(recording)
    peaks = [cycle.peak_friction for cycle in cycles] if friction is not None else []
    return Summary(
        cylinder=recording.metadata.get('cylinder', 'unknown'),
        friction_model=recording.metadata.get('friction_model', 'unknown'),
        seed=recording.metadata.get('seed', 'unknown'),
        source=recording.metadata.get('source'),
        duration=recording.duration,
        samples=recording.position.size,
        interval=recording.interval,
        travel=float(np.ptp(recording.position)),
        peak_friction=max(peaks, default=None),
        cycles=tuple(cycles),
        rate=rate,
        jitter_p50=jitter_p50,
        jitter_p99=jitter_p99,
        lost=lost_samples(recording),
    )


def measure_timing(recording: Recording) -> tuple[float, float, float]:
    """
    Return the rate [Hz], and median and 99th percentile of the jitter [s] of the samples.

    The delay of a sample is its arrival time minus its stamp; jitter is the distance of a delay
    from the median. NaN for recordings that are too short.
    """
    index = np.flatnonzero(recording.arrival_ns != NEVER)
    arrival = recording.arrival_ns[index]
    span = (arrival[-1] - arrival[0]) * 1e-9 if index.size > 1 else 0.0
    rate = (index[-1] - index[0]) / span if span > 0 else float('nan')
    delay = (arrival - recording.stamps[index]).astype(np.float64)
    jitter = np.abs(delay - np.median(delay)) * 1e-9
    p50, p99 = np.percentile(jitter, [50, 99])
    return float(rate), float(p50), float(p99)


def lost_samples(recording: Recording) -> dict[str, int]:
    """
    Return topic -> number of samples that are not in the bag, by stamp where there is one.

    The live friction estimate cannot cover the first and the last samples, as many as it is late;
    they are not lost.
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
