"""Comparison of a measured run with a simulation of it, or with another measured run."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from pneu_rig_ros.analysis.friction import ForceBalance
from pneu_rig_ros.analysis.metrics import (
    LEAST_SAMPLES,
    AnalysedRun,
    SignalGap,
    analyse_run,
    compare_signals,
    signal_noise,
)
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.plant import Plant
from pneu_rig_ros.records import Recording, read_recording
from pneu_rig_ros.records.conditions import (
    CONDITIONS,
    apply_conditions,
    check_plausible,
    configured_conditions,
)
from pneu_rig_ros.records.recording import WHOLE
from pneu_rig_ros.rig import RigConfiguration
from pneu_rig_ros.rig.sensors import IDEAL, near_zero, sensor_noise
from pneu_rig_ros.rig.valve_drive import DAC_STEP

INITIAL_TIME = 0.01
"""Length of the readings whose mean is the initial position [s]."""

SIMULATED = 'simulated'
"""Label of a second run that is a model's."""


@dataclass(frozen=True)
class Comparison:
    """
    Two runs on one time axis: a bag, and a model's run or another bag.

    :param gaps: signal -> error metrics
    :param shift: delay of the second run's time [s], 0 for a model
    :param conditions: name -> value used [SI]; those that the first bag lacks are the model's
    :param second: label of the second run
    """

    measured: AnalysedRun
    simulated: AnalysedRun
    gaps: Mapping[str, SignalGap]
    shift: float
    conditions: Mapping[str, float]
    second: str

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON, SI units."""
        bag = self.measured.recording
        return {
            'measured': bag.name,
            'model': self.simulated.recording.name,
            'samples': bag.size,
            'interval': bag.interval,
            'shift': self.shift,
            'conditions': {
                name: {
                    'value': value,
                    'unit': CONDITIONS[name].unit,
                    'from': 'bag' if name in bag.conditions else 'model',
                }
                for name, value in self.conditions.items()
            },
            'signals': {
                name: {**gap._asdict(), 'multiple': gap.multiple}
                for name, gap in self.gaps.items()
            },
            'events': {
                'measured': _events_to_dict(self.measured),
                'model': _events_to_dict(self.simulated),
            },
        }


def _events_to_dict(run: AnalysedRun) -> dict[str, Any]:
    cycles = [cycle.to_dict() for cycle in run.cycles]
    return {'cycle_count': len(cycles), 'stroke_time': run.stroke_time, 'cycles': cycles}


def compare_with_model(
    bag: Path | str, configuration: RigConfiguration, name: str | None = None
) -> Comparison:
    """
    Compare a bag with a simulation from its initial state, with its conditions and voltages.

    :param name: of the simulated run; that of the cylinder if omitted
    :raises RigError: when the bag cannot be read, has no voltages to drive the model with, or its
        conditions are out of range
    """
    recording = read_recording(bag)
    if not recording.driven:
        raise RigError(
            f'{bag}: no valve_voltages recorded, which a simulation needs; '
            'import it with u, or voltage_1 and voltage_2'
        )
    model = apply_conditions(configuration, recording.conditions)
    check_plausible(bag, recording.signals, model)
    measured = replace(recording, name=str(bag), configuration=_rig(recording) or model)
    simulated = simulate_record(recording, model, name)
    return _comparison(measured, simulated, 0.0, configured_conditions(model), SIMULATED)


def compare_with_bag(bag: Path | str, other: Path | str, shift: float | None = None) -> Comparison:
    """
    Compare a bag with another one.

    :param shift: delay of the second one's time [s]; estimated from the onset of the command
        when not given
    :raises RigError: when one cannot be read, or they do not overlap
    """
    recordings = read_recording(bag), read_recording(other)
    rigs = [_rig(recording) for recording in recordings]
    first, second = (
        replace(recording, name=str(path), configuration=rig or rigs[0] or rigs[1])
        for path, recording, rig in zip((bag, other), recordings, rigs, strict=True)
    )
    late = estimate_shift(first, second) if shift is None else shift
    used = configured_conditions(rigs[0]) if rigs[0] else first.conditions
    return _comparison(*resample_overlap(first, second, late), late, used, 'second bag')


def simulate_record(
    recording: Recording, configuration: RigConfiguration, name: str | None = None
) -> Recording:
    """
    Simulate a recorded run from its position and pressures, with its voltages.

    The signals are the true ones, without sensors, at the instants of the measured run. A pressure
    that is read near its sensor's zero starts there: a vented chamber, of which a few pascals more
    would move every later slip.

    :param configuration: the rig under the conditions of the run
    :param name: of the simulated run; that of the cylinder when not given
    """
    start = slice(0, max(1, round(INITIAL_TIME / recording.interval)))
    position, stroke = recording.position[start].mean(), configuration.model.cylinder.stroke
    sensors = _sensors(recording.configuration or configuration)
    noise, zero = sensors[1] if sensors else 0.0, configuration.model.gas.atmospheric_pressure
    p1, p2 = (
        zero if near_zero(pressure, zero, noise) else pressure
        for pressure in (float(recording.pressure_1[0]), float(recording.pressure_2[0]))
    )
    operation = configuration.model.operation._replace(
        initial_position=min(max(float(position), 0.0), stroke),
        initial_pressure_1=p1,
        initial_pressure_2=p2,
    )
    plant = Plant(configuration.model._replace(operation=operation), configuration.effects)
    first = plant.state
    voltages = np.column_stack([recording.voltage_1, recording.voltage_2])
    run = plant.run(voltages[:-1], recording.interval)
    signals = {key: np.append(getattr(first, key), getattr(run, key)) for key in WHOLE}
    signals |= {'voltage_1': voltages[:, 0], 'voltage_2': voltages[:, 1]}
    return Recording(
        name or configuration.name,
        recording.start_ns,
        recording.interval_ns,
        signals,
        configuration=configuration,
    )


def command_onset(recording: Recording) -> float | None:
    """
    Return when the voltages of the two valves first differ, [s] since the first sample.

    None if the valves stay centred, or if the voltages are not recorded.
    """
    if not recording.driven:
        return None
    driven = np.abs(recording.voltage_1 - recording.voltage_2) > 2.5 * DAC_STEP
    return float(recording.time[driven.argmax()]) if driven.any() else None


def estimate_shift(measured: Recording, other: Recording) -> float:
    """
    Return the delay of the other recording's time [s], estimated from the onset of the command.

    0 if one of them has no onset. Stick-slip events are not used, because they are compared.
    """
    first, second = command_onset(measured), command_onset(other)
    return 0.0 if first is None or second is None else second - first


def resample_overlap(
    measured: Recording, other: Recording, shift: float
) -> tuple[Recording, Recording]:
    """
    Return the overlap of both runs, the other one resampled to the time of the measured one.

    The other one retains position and pressures only.

    :param shift: time in the other run at the measured one's time 0 [s]
    :raises RigError: when they do not overlap
    """
    time = measured.time + shift
    last = other.time[-1] + 0.5 * min(measured.interval, other.interval)
    inside = np.flatnonzero((time >= -0.5 * other.interval) & (time <= last))
    if inside.size < LEAST_SAMPLES:
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


def _comparison(
    measured: Recording,
    simulated: Recording,
    shift: float,
    used: Mapping[str, float],
    second: str,
) -> Comparison:
    rig = measured.configuration
    noise = _sensors(rig)
    levels = signal_noise(*noise, measured.interval, ForceBalance.of(rig)) if rig and noise else {}
    sides = analyse_run(measured), analyse_run(simulated)
    gaps = compare_signals(sides[0].signals, sides[1].signals, levels)
    return Comparison(*sides, gaps, shift, used, second)


def _rig(recording: Recording) -> RigConfiguration | None:
    """Return the recording's own rig under its conditions."""
    own = recording.configuration
    return own and apply_conditions(own, recording.conditions)


def _sensors(rig: RigConfiguration | None) -> tuple[float, float] | None:
    """Return the noise of position [m] and pressure [Pa]; None if it is 0 or not known."""
    return None if rig is None or rig.sensors.kind == IDEAL else sensor_noise(rig.sensors)
