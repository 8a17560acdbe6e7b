"""
The rig offline: plant, valve command and friction estimator in one loop, straight into a bag.

The messages are those of the live nodes in lock step with simulated time: same topics, same bytes,
same stamps from 0 ns on, arrival times equal to the simulated time at which they are sent.
"""

import math
from collections.abc import Callable, Iterator
from pathlib import Path

from pneu_rig_ros.analysis.friction import CausalFriction, ForceBalance, can_estimate
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
    rig, description, names = Rig(configuration), describe(configuration), absolute_names('')
    with BagWriter(path) as writer:
        try:
            for topic, now_ns, cdr in _messages(rig, description, u, samples, progress):
                writer.write(names[topic], TOPICS[topic].type, now_ns, cdr)
        finally:
            # A run that is stopped half way still leaves a complete bag.
            writer.close(bag_metadata(description))
    return Path(path)


def sample_count(configuration: RigConfiguration, duration: float) -> int:
    """Return how many samples a duration [s] holds, the first one at 0 s included."""
    if not (math.isfinite(duration) and duration > 0):
        raise RigError(f'duration = {duration} s, must be a positive number of seconds')
    # Half a nanosecond of slack, as 1.16e-3 s is not exactly a binary fraction.
    return int((duration * 1e9 + 0.5) // configuration.interval_ns) + 1


def _messages(
    rig: Rig, description: str, u: float, samples: int, progress: Progress
) -> Iterator[tuple[str, int, bytes]]:
    """Yield topic, log time [ns] and bytes of all messages under a constant command [V]."""
    configuration, interval_ns = rig.configuration, rig.configuration.interval_ns
    estimator: CausalFriction | None = None
    if can_estimate(rig.interval):
        estimator = CausalFriction(ForceBalance.of(configuration), rig.interval)
    plant = PlantMessages(rig.sensors.pressure_variance, clock=True)
    friction = template('friction')
    voltages = valve_voltages(u)
    command = pack_valve_voltages(*voltages)
    yield 'rig_description', 0, pack_string(description)
    yield 'robot_description', 0, pack_string(robot_description(configuration))
    yield 'u', 0, pack_float64(u)
    for now_ns in range(0, samples * interval_ns, interval_ns):
        sample = rig.sample
        for topic, cdr in plant.pack(sample, now_ns).items():
            yield topic, now_ns, cdr
        if estimator is not None:
            force = estimator.push(sample.position, sample.pressure_1, sample.pressure_2)
            if force is not None:
                stamp_ns = now_ns - estimator.delay_samples * interval_ns
                yield 'friction', stamp_ns, friction.at(stamp_ns, force)
        last = sample.index + 1 == samples
        if not last:
            yield 'valve_voltages', now_ns, command
            rig.step(*voltages)
        if sample.index % REPORT_EVERY == 0 or last:
            progress(now_ns * 1e-9)
