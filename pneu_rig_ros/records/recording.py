"""
A recording: signals on one uniform grid, whatever they were read from or made by.

It may be of a whole rig or of a part of one, from a bag, a text table or a simulation.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.arrays import Floats, Integers
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.reading_noise import noise_of, smallest_step
from pneu_rig_ros.rig import RigConfiguration
from pneu_rig_ros.rig.sensors import can_filter
from pneu_rig_ros.rig.valve_drive import voltages_of

Stamps = Integers

SIGNALS = {
    'position': 'm',
    'velocity': 'm/s',
    'pressure_1': 'Pa',
    'pressure_2': 'Pa',
    'u': 'V',
    'voltage_1': 'V',
    'voltage_2': 'V',
    'force': 'N',
    'friction': 'N',
}
"""Signal -> its SI unit; a `force` is measured, `friction` estimated."""

PRESSURES = ('pressure_1', 'pressure_2')

WHOLE = ('position', *PRESSURES)
"""Signals without which a recording is that of a part of a rig."""

VELOCITY_CUTOFF = 32.0
"""Low-pass of a velocity made from positions [Hz], as the rig's own."""

NEVER = -1
"""Arrival time of a sample that was not received."""


@dataclass(frozen=True, eq=False)
class Recording:
    """
    Signals of n samples, sample k taken at ``start_ns + k * interval_ns`` exactly.

    Where a sample is missing its value is interpolated, and its stamp is in `missing`. Arrays are
    read-only.

    :param name: the bag's directory, or the text table without its ending
    :param start_ns: stamp of the first sample [ns]
    :param interval_ns: sampling interval [ns]
    :param signals: name of :data:`SIGNALS` -> values, SI units, absolute pressures, shape (n,);
        finite but for `friction`, which is NaN where nothing was estimated
    :param missing: topic of a bag, or signal -> stamps of the samples it lacks [ns]
    :param arrival_ns: when the recorder got each sample [ns], shape (n,), NEVER if it did not;
        the stamps themselves when not given
    :param counts: topic -> number of messages in the bag
    :param metadata: custom data of the bag; `source` is what was imported
    :param configuration: the rig, None if it is not known
    :param protected: whether no message lacked a checksum, so that no bit can have changed
    :param notes: remarks for the user
    :param conditions: those of the run that are known, see `records.conditions`, SI units
    :param atmospheric_pressure: zero of the gauge pressures that were converted [Pa], None if
        there were none
    :raises RigError: for no signal, different lengths, a value that is not finite or a stamp that
        is off the grid
    """

    name: str
    start_ns: int
    interval_ns: int
    signals: Mapping[str, Floats]
    missing: Mapping[str, Stamps] = field(default_factory=dict)
    arrival_ns: Stamps = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    counts: Mapping[str, int] = field(default_factory=dict)
    metadata: Mapping[str, str] = field(default_factory=dict)
    configuration: RigConfiguration | None = None
    protected: bool = True
    notes: tuple[str, ...] = ()
    conditions: Mapping[str, float] = field(default_factory=dict)
    atmospheric_pressure: float | None = None

    def __post_init__(self) -> None:
        """Validate, and make the arrays read-only."""
        if self.interval_ns <= 0:
            raise RigError(
                f'{self.name}: sampling interval {self.interval_ns} ns, must be positive'
            )
        if not self.size:
            raise RigError(f'{self.name}: no samples')
        values = {name: self._checked(name, values) for name, values in self.signals.items()}
        arrival = self.arrival_ns if self.arrival_ns.size else self.stamps
        object.__setattr__(self, 'signals', values)
        object.__setattr__(self, 'arrival_ns', self._of_size('arrival_ns', arrival))
        for topic, stamps in self.missing.items():
            check_stamps(stamps, self.start_ns, self.interval_ns, f'{self.name}: {topic}')

    def _checked(self, name: str, values: Floats) -> Floats:
        bad = np.isinf(values) if name == 'friction' else ~np.isfinite(values)
        if bad.any():
            k = int(bad.argmax())
            raise RigError(f'{self.name}: {name} is {values[k]} at sample {k}, must be finite')
        return np.asarray(self._of_size(name, values), dtype=np.float64)

    def _of_size(self, name: str, values: NDArray[np.generic]) -> NDArray[np.generic]:
        if values.shape != (self.size,):
            first = next(iter(self.signals))
            raise RigError(
                f'{self.name}: {name} has shape {values.shape}, {first} has ({self.size},)'
            )
        kept = values.view()
        kept.flags.writeable = False
        return kept

    def __getitem__(self, name: str) -> Floats:
        """Return a signal, shape (n,); RigError if it was not recorded."""
        if name not in self.signals:
            there = ', '.join(self.signals)
            raise RigError(f'{self.name}: no {name} in it; it has {there}')
        return self.signals[name]

    def __contains__(self, name: object) -> bool:
        """Return whether a signal was recorded."""
        return name in self.signals

    @property
    def size(self) -> int:
        """Number of samples n."""
        return next((values.size for values in self.signals.values()), 0)

    @property
    def interval(self) -> float:
        """Sampling interval [s]."""
        return self.interval_ns * 1e-9

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return 1e-9 * self.interval_ns * (self.size - 1)

    @property
    def stamps(self) -> Stamps:
        """Stamps of the samples [ns], shape (n,)."""
        return self.start_ns + self.interval_ns * np.arange(self.size, dtype=np.int64)

    @property
    def time(self) -> Floats:
        """Time since the first sample [s], shape (n,)."""
        return np.asarray((self.stamps - self.start_ns) * 1e-9, dtype=np.float64)

    @property
    def position(self) -> Floats:
        """Position [m], shape (n,)."""
        return self['position']

    @cached_property
    def velocity(self) -> Floats:
        """Velocity [m/s], shape (n,); where none was recorded made as the rig itself does."""
        if 'velocity' in self:
            return self['velocity']
        return smoothed_velocity(self.position, self.interval)

    @property
    def pressure_1(self) -> Floats:
        """Absolute pressure of the cap end [Pa], shape (n,)."""
        return self['pressure_1']

    @property
    def pressure_2(self) -> Floats:
        """Absolute pressure of the rod end [Pa], shape (n,)."""
        return self['pressure_2']

    @property
    def voltage_1(self) -> Floats:
        """Voltage of valve 1 from each sample on [V], shape (n,)."""
        return self._voltages[0]

    @property
    def voltage_2(self) -> Floats:
        """Voltage of valve 2 from each sample on [V], shape (n,)."""
        return self._voltages[1]

    @property
    def friction(self) -> Floats:
        """Friction force that was estimated live [N], shape (n,), NaN where it was not."""
        return self['friction']

    @property
    def driven(self) -> bool:
        """Whether it is known what voltages the valves got."""
        return 'u' in self or ('voltage_1' in self and 'voltage_2' in self)

    @cached_property
    def _voltages(self) -> tuple[Floats, Floats]:
        """Valve voltages as recorded, else by Eq. 1 from u [V]."""
        if 'u' in self and not ('voltage_1' in self and 'voltage_2' in self):
            return voltages_of(self['u'])
        return self['voltage_1'], self['voltage_2']

    @cached_property
    def noise(self) -> Mapping[str, float]:
        """Signal -> standard deviation of a reading, by the readings and the converter's step."""
        return {name: noise_of(values) for name, values in self.signals.items()}

    @cached_property
    def resolution(self) -> Mapping[str, float]:
        """Signal -> smallest step between readings, that of its converter; 0 if it has none."""
        return {name: smallest_step(values) for name, values in self.signals.items()}

    def cut(self, first: int, end: int) -> Recording:
        """Return the samples from `first` to before `end`."""
        start_ns, end_ns = (self.start_ns + k * self.interval_ns for k in (first, end))
        inside = {
            topic: stamps[(stamps >= start_ns) & (stamps < end_ns)]
            for topic, stamps in self.missing.items()
        }
        signals = {name: values[first:end] for name, values in self.signals.items()}
        arrival = self.arrival_ns[first:end]
        return replace(
            self, start_ns=start_ns, signals=signals, missing=inside, arrival_ns=arrival
        )

    def with_signals(self, **signals: Floats) -> Recording:
        """Return the recording with these signals in place of its own, or beside them."""
        return replace(self, signals={**self.signals, **signals})


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


def smoothed_velocity(position: Floats, interval: float) -> Floats:
    """
    Return the velocity [m/s] as the rig's own data acquisition makes it, shape (n,).

    The differentiated position through a first-order low-pass at 32 Hz, without it where the
    sampling is too slow for one.

    :param position: [m], shape (n,)
    :param interval: [s]
    """
    slope = np.diff(position, prepend=position[:1]) / interval
    if not can_filter(VELOCITY_CUTOFF, interval):
        return slope
    return low_pass(slope, interval, VELOCITY_CUTOFF)


def low_pass(signal: Floats, interval: float, cutoff: float) -> Floats:
    """
    Return a signal through a first-order Butterworth low-pass, in steady state at first.

    `scipy.signal.lfilter` does the same, but most of the time in which a command or a node starts
    would be spent on loading it.

    :param signal: shape (n,)
    :param interval: [s]
    :param cutoff: [Hz], below half the sampling rate
    """
    warped = np.tan(np.pi * cutoff * interval)
    pole = (1.0 - warped) / (1.0 + warped)
    drive = 0.5 * (1.0 - pole) * (signal + np.concatenate([signal[:1], signal[:-1]]))
    first = float(signal[0])
    steps = itertools.accumulate(memoryview(drive), lambda y, x: pole * y + x, initial=first)
    return np.fromiter(steps, np.float64, drive.size + 1)[1:]
