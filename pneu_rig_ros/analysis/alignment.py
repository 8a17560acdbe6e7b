"""Two records brought to one time axis."""

from __future__ import annotations

import numpy as np

from pneu_rig_ros.analysis.comparison import Run
from pneu_rig_ros.analysis.friction import Floats
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import Recording
from pneu_rig_ros.rig.valve_drive import DAC_STEP

LEAST_OVERLAP = 4
"""Samples that two runs must share."""


def command_onset(record: Recording) -> float | None:
    """
    Return when the valve voltages first change [s] since the first sample.

    0 for a record that starts with the valves driven already: their voltages differ. None for one
    whose valves stay in the middle.
    """
    driven = np.abs(record.voltage_1 - record.voltage_2) > 2.5 * DAC_STEP
    return float(record.time[driven.argmax()]) if driven.any() else None


def shift_between(measured: Recording, other: Recording) -> float:
    """
    Return by how much the other record's time is late [s], by the onset of the command.

    0 where one of them has none. Stick-slip itself is no clock: its events are to be compared.
    """
    onsets = command_onset(measured), command_onset(other)
    return 0.0 if None in onsets else float(onsets[1] or 0.0) - float(onsets[0] or 0.0)


def common(measured: Run, other: Run, shift: float) -> tuple[Run, Run]:
    """
    Return both runs on the grid of the measured one, as far as both go.

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
    part = slice(int(inside[0]), int(inside[-1]) + 1)

    def resampled(signal: Floats) -> Floats:
        return np.asarray(np.interp(time[part], other.time, signal))

    return _with(measured, measured.interval, *(s[part] for s in _readings(measured))), _with(
        other, measured.interval, *map(resampled, _readings(other))
    )


def _readings(run: Run) -> tuple[Floats, Floats, Floats]:
    return run.position, run.pressure_1, run.pressure_2


def _with(run: Run, interval: float, x: Floats, p1: Floats, p2: Floats) -> Run:
    return Run(run.name, interval, x, p1, p2, run.balance, run.stroke)
