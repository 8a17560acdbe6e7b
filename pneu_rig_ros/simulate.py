"""
The rig offline: plant, valve command and friction estimator in one loop, straight into a bag.

The messages are those of the live nodes in lock step with simulated time: same topics, same bytes,
same stamps from 0 ns on, arrival times equal to the simulated time at which they are sent.
"""

import math
from collections.abc import Callable
from pathlib import Path

from pneu_rig_ros.analysis.friction import CausalFriction, ForceBalance
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import BagWriter
from pneu_rig_ros.records.cdr_encoding import (
    PlantMessages,
    pack_float64,
    pack_string,
    pack_valve_voltages,
    template,
)
from pneu_rig_ros.records.description import bag_metadata, describe
from pneu_rig_ros.records.topics import TOPICS, absolute_names
from pneu_rig_ros.rig import Rig, RigConfiguration
from pneu_rig_ros.rig.urdf import robot_description
from pneu_rig_ros.rig.valve_drive import valve_voltages

Progress = Callable[[float], None]
"""Called with the simulated time [s] from time to time."""

REPORT_EVERY = 512
"""Samples between two calls of the progress function."""


def simulate(
    configuration: RigConfiguration,
    u: float,
    duration: float,
    path: Path | str,
    progress: Progress = lambda _: None,
) -> Path:
    """
    Run the rig with a constant command and record it.

    :param configuration: the rig
    :param u: command of Eq. 1 [V]
    :param duration: simulated time [s]; the bag holds floor(duration / interval) + 1 samples
    :param path: the bag's directory, must not exist
    :param progress: called with the simulated time [s], from 0 to the end
    :raises RigError: when u or the duration is not usable or the bag cannot be written
    """
    if not math.isfinite(u):
        raise RigError(f'u = {u} V, must be a finite number of volts')
    samples = sample_count(configuration, duration)
    rig = Rig(configuration)
    with BagWriter(path) as writer:
        recording = _Recording(writer, rig)
        try:
            recording.run(u, samples, progress)
        finally:
            # A run that is stopped half way still leaves a complete bag.
            writer.close(bag_metadata(recording.description))
    return Path(path)


def sample_count(configuration: RigConfiguration, duration: float) -> int:
    """Return how many samples a duration [s] holds, the first one at 0 s included."""
    if not (math.isfinite(duration) and duration > 0):
        raise RigError(f'duration = {duration} s, must be a positive number of seconds')
    # Half a nanosecond of slack, as 1.16e-3 s is not exactly a binary fraction.
    return int((duration * 1e9 + 0.5) // configuration.interval_ns) + 1


class _Recording:
    """A rig and the bag that its messages go to."""

    def __init__(self, writer: BagWriter, rig: Rig) -> None:
        self._write = writer.write
        self._rig = rig
        self._names = absolute_names('')
        self._interval_ns = rig.configuration.interval_ns
        self._estimator = CausalFriction(ForceBalance.of(rig.configuration), rig.interval)
        self._messages = PlantMessages(rig.pressure_variance, clock=True)
        self._friction = template('friction')
        self.description = describe(rig.configuration)

    def run(self, u: float, samples: int, progress: Progress) -> None:
        """Record the samples 0 ... samples - 1 under a constant command [V]."""
        voltages = valve_voltages(u)
        command = pack_valve_voltages(*voltages)
        self._put('rig_description', 0, pack_string(self.description))
        self._put('robot_description', 0, pack_string(robot_description(self._rig.configuration)))
        self._put('u', 0, pack_float64(u))
        self._rig.reset()
        for index in range(samples):
            self._tick(index * self._interval_ns)
            if index + 1 < samples:
                self._put('valve_voltages', index * self._interval_ns, command)
                self._rig.step(*voltages)
            if index % REPORT_EVERY == 0 or index + 1 == samples:
                progress(index * self._interval_ns * 1e-9)

    def _tick(self, now_ns: int) -> None:
        """Put the messages of one sampling instant."""
        sample = self._rig.sample
        for topic, cdr in self._messages.pack(sample, now_ns).items():
            self._put(topic, now_ns, cdr)
        force = self._estimator.push(sample.position, sample.pressure_1, sample.pressure_2)
        if force is not None:
            stamp_ns = now_ns - self._estimator.delay_samples * self._interval_ns
            self._put('friction', stamp_ns, self._friction.at(stamp_ns, force))

    def _put(self, topic: str, now_ns: int, cdr: bytes) -> None:
        self._write(self._names[topic], TOPICS[topic].type, now_ns, cdr)
