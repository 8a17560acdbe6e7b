"""Two recordings brought to one time axis."""

from __future__ import annotations

import numpy as np

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import Recording
from pneu_rig_ros.records.recording import WHOLE
from pneu_rig_ros.rig.valve_drive import DAC_STEP

LEAST_OVERLAP = 4
"""Samples that two runs must share."""


def command_onset(recording: Recording) -> float | None:
    """
    Return when the valve voltages first change [s] since the first sample.

    0 for a recording that starts with the valves driven already: their voltages differ. None for
    one whose valves stay in the middle, or whose voltages are not known.
    """
    if not recording.driven:
        return None
    driven = np.abs(recording.voltage_1 - recording.voltage_2) > 2.5 * DAC_STEP
    return float(recording.time[driven.argmax()]) if driven.any() else None


def shift_between(measured: Recording, other: Recording) -> float:
    """
    Return by how much the other recording's time is late [s], by the onset of the command.

    0 where one of them has none. Stick-slip itself is no clock: its events are to be compared.
    """
    onsets = command_onset(measured), command_onset(other)
    return 0.0 if None in onsets else float(onsets[1] or 0.0) - float(onsets[0] or 0.0)


def common(measured: Recording, other: Recording, shift: float) -> tuple[Recording, Recording]:
    """
    Return both runs on the grid of the measured one, as far as both go.

    The other one keeps position and pressures only.

    :param shift: time in the other run at the measured one's time 0 [s]
    :raises RigError: when they do not overlap
    """
    time = measured.time + shift
    last = other.time[-1] + 0.5 * min(measured.interval, other.interval)
    inside = np.flatnonzero((time >= -0.5 * other.interval) & (time <= last))
    if inside.size < LEAST_OVERLAP:
        raise RigError(
            f'{measured.name} and {other.name} do not overlap when the second is shifted by '
            f'{-shift:g} s'
        )
    first, end = int(inside[0]), int(inside[-1]) + 1
    part = measured.cut(first, end)
    signals = {name: np.interp(time[first:end], other.time, other[name]) for name in WHOLE}
    return part, Recording(
        other.name, part.start_ns, part.interval_ns, signals, configuration=other.configuration
    )
