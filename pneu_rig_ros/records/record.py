"""A record: the rig's signals on one sampling grid, validated when it is constructed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.rig import RigConfiguration

Floats = NDArray[np.float64]
Stamps = NDArray[np.int64]

UNITS = {
    'position': 'm',
    'velocity': 'm/s',
    'pressure_1': 'Pa',
    'pressure_2': 'Pa',
    'voltage_1': 'V',
    'voltage_2': 'V',
    'friction': 'N',
}
"""Signal of a record -> its unit."""

NEVER = -1
"""Arrival time of a sample that is not in the bag."""


@dataclass(frozen=True)
class Record:
    """
    Signals of n samples, sample k taken at ``start_ns + k * interval_ns`` exactly.

    Where a sample is missing its value is interpolated linearly, and its stamp is in `missing`.
    Pressures are absolute. Arrays are read-only.

    :param start_ns: stamp of the first sample [ns]
    :param interval_ns: sampling interval [ns]
    :param position: [m], shape (n,)
    :param velocity: as the rig's data acquisition says it [m/s], shape (n,)
    :param pressure_1: cap end [Pa], shape (n,)
    :param pressure_2: rod end [Pa], shape (n,)
    :param voltage_1: of valve 1 from this sample on [V], shape (n,)
    :param voltage_2: of valve 2 from this sample on [V], shape (n,)
    :param friction: estimated live, F_r of Eq. 2 [N], shape (n,); NaN where nothing was recorded
    :param arrival_ns: when the recorder got each sample [ns], shape (n,); NEVER if it did not
    :param missing: stamped topic -> stamps of the samples it lacks [ns]
    :param counts: topic -> number of messages in the bag
    :param configuration: the rig, None if the bag does not say
    :param metadata: custom data of the bag
    :param protected: whether checksums stood by every message, so that no bit can have changed
    :raises RigError: when lengths differ, a value is not finite or a stamp is off the grid
    """

    start_ns: int
    interval_ns: int
    position: Floats
    velocity: Floats
    pressure_1: Floats
    pressure_2: Floats
    voltage_1: Floats
    voltage_2: Floats
    friction: Floats
    arrival_ns: Stamps
    missing: Mapping[str, Stamps] = field(default_factory=dict)
    counts: Mapping[str, int] = field(default_factory=dict)
    configuration: RigConfiguration | None = None
    metadata: Mapping[str, str] = field(default_factory=dict)
    protected: bool = True

    def __post_init__(self) -> None:
        """Validate, and make the arrays read-only."""
        if self.interval_ns <= 0:
            raise RigError(f'record: sampling interval {self.interval_ns} ns, must be positive')
        length = self.position.size
        if length == 0:
            raise RigError('record: no samples')
        for name in (*UNITS, 'arrival_ns'):
            self._validate(name, length)
        for topic, stamps in self.missing.items():
            check_stamps(stamps, self.start_ns, self.interval_ns, topic)

    def _validate(self, name: str, length: int) -> None:
        values: NDArray[np.generic] = getattr(self, name)
        if values.shape != (length,):
            raise RigError(f'record: {name} has shape {values.shape}, position has ({length},)')
        bad = np.isinf(values) if name == 'friction' else ~np.isfinite(values)
        if bad.any():
            k = int(bad.argmax())
            raise RigError(f'record: {name} is {values[k]} at sample {k}, must be finite')
        values.flags.writeable = False

    @property
    def interval(self) -> float:
        """Sampling interval [s]."""
        return self.interval_ns * 1e-9

    @property
    def stamps(self) -> Stamps:
        """Stamps of the samples [ns], shape (n,)."""
        return self.start_ns + self.interval_ns * np.arange(self.position.size)

    @property
    def time(self) -> Floats:
        """Time since the first sample [s], shape (n,)."""
        return np.asarray((self.stamps - self.start_ns) * 1e-9, dtype=np.float64)

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return 1e-9 * self.interval_ns * (self.position.size - 1)


MOST_MISSING = 1_000_000
"""So many samples may be missing beside ten for each that there is."""


def check_gaps(wanted: int, there: int) -> None:
    """
    Raise RigError when far more samples are missing than there are: some stamp must be wrong.

    :param wanted: samples from the first stamp to the last
    :param there: samples that there are
    """
    if wanted > 10 * there + MOST_MISSING:
        raise RigError(f'{there} samples are stamped as if they were {wanted}: is a stamp wrong, '
                       'or were two recordings put together?')  # fmt: skip


def check_stamps(stamps: Stamps, start_ns: int, interval_ns: int, topic: str) -> None:
    """Raise RigError unless the stamps [ns] increase strictly and lie on the sampling grid."""
    steps = np.diff(stamps)
    if (steps <= 0).any():
        k = int((steps <= 0).argmax())
        raise RigError(
            f'{topic}: stamp {stamps[k + 1]} ns comes after {stamps[k]} ns; stamps must increase '
            '(was the plant reset during the recording?)'
        )
    off = (stamps - start_ns) % interval_ns
    if off.any():
        k = int(off.astype(bool).argmax())
        raise RigError(
            f'{topic}: stamp {stamps[k]} ns is {off[k]} ns off the sampling grid of '
            f'{interval_ns} ns that starts at {start_ns} ns'
        )
