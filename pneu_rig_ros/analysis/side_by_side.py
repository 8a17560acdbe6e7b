"""A measured bag beside a model of its rig, or beside another bag."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pneu_rig_ros.analysis.alignment import common, shift_between
from pneu_rig_ros.analysis.comparison import (
    Compared,
    Events,
    SignalGap,
    compare_signals,
    compared,
    signal_noise,
)
from pneu_rig_ros.analysis.friction import ForceBalance
from pneu_rig_ros.analysis.rerun import rerun
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import Recording, read_recording
from pneu_rig_ros.records.conditions import CONDITIONS, apply_conditions
from pneu_rig_ros.records.plausible import check_plausible
from pneu_rig_ros.rig import RigConfiguration
from pneu_rig_ros.rig.sensors import IDEAL, sensor_noise


class Condition(NamedTuple):
    """
    A condition of the run.

    :param name: of `records.conditions.CONDITIONS`
    :param value: SI
    :param measured: whether the bag says so; else it is the model's
    """

    name: str
    value: float
    measured: bool


@dataclass(frozen=True)
class Comparison:
    """
    Two runs on one time axis.

    :param measured: the first bag
    :param simulated: the model's run, or the second bag
    :param gaps: signal -> how far they are apart
    :param noise: signal -> standard deviation of the measured one, {} where it is not known
    :param shift: by how much the second run's time was late [s], 0 for a model
    :param conditions: of the first bag
    :param second: what to call the second run
    """

    measured: Compared
    simulated: Compared
    gaps: Mapping[str, SignalGap]
    noise: Mapping[str, float]
    shift: float
    conditions: tuple[Condition, ...]
    second: str

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON, SI units."""
        return {
            'measured': self.measured.recording.name,
            'model': self.simulated.recording.name,
            'samples': self.measured.recording.size,
            'interval': self.measured.recording.interval,
            'shift': self.shift,
            'conditions': {c.name: {'value': c.value, 'unit': CONDITIONS[c.name].unit,
                                    'from': 'bag' if c.measured else 'model'}
                           for c in self.conditions},
            'signals': {name: {**gap._asdict(), 'multiple': gap.multiple}
                        for name, gap in self.gaps.items()},
            'events': {'measured': _plain(self.measured.events),
                       'model': _plain(self.simulated.events)},
        }  # fmt: skip


def _plain(events: Events) -> dict[str, Any]:
    cycles = [
        {key: None if np.isnan(value) else value for key, value in cycle._asdict().items()}
        for cycle in events.cycles
    ]
    return {'cycle_count': len(cycles), 'stroke_time': events.stroke_time, 'cycles': cycles}


def compare_with_model(
    bag: Path | str, configuration: RigConfiguration, name: str | None = None
) -> Comparison:
    """
    Compare a bag with a model that gets its conditions, its voltages and its start.

    :param configuration: the model
    :param name: what to call it; the name of its cylinder when not given
    :raises RigError: when the bag cannot be read, has no voltages to drive the model with, or its
        conditions are out of range
    """
    recording = read_recording(bag)
    if not recording.driven:
        raise RigError(f'{bag}: no valve_voltages in it, so that no model can be driven; '
                       'import it with u, or voltage_1 and voltage_2')  # fmt: skip
    model = apply_conditions(configuration, recording.conditions)
    check_plausible(bag, recording.signals, model)
    measured = replace(recording, name=str(bag), configuration=_rig(recording) or model)
    simulated = rerun(recording, model, name)
    noise = _sensors(recording.configuration or configuration)
    used = _all_conditions(model)
    return _compared(measured, simulated, noise, 0.0, used, 'simulated')


def compare_with_bag(
    bag: Path | str, other: Path | str, shift: float | None = None
) -> Comparison:  # fmt: skip
    """
    Compare a bag with another one.

    :param shift: by how much the second one's time is late [s]; found from the onset of the
        command when not given
    :raises RigError: when one cannot be read, or they do not overlap
    """
    recordings = read_recording(bag), read_recording(other)
    rigs = [_rig(recording) for recording in recordings]
    first, second = (
        replace(recording, name=str(path), configuration=rig or rigs[0] or rigs[1])
        for path, recording, rig in zip((bag, other), recordings, rigs, strict=True)
    )
    late = shift_between(first, second) if shift is None else shift
    used = _all_conditions(rigs[0]) if rigs[0] else first.conditions
    noise = _sensors(rigs[0] or rigs[1])
    return _compared(*common(first, second, late), noise, late, used, 'second bag')


def _compared(
    measured: Recording, simulated: Recording, noise: tuple[float, float] | None, shift: float,
    used: Mapping[str, float], second: str,
) -> Comparison:  # fmt: skip
    rig = measured.configuration
    balance = ForceBalance.of(rig) if rig else None
    levels = {} if noise is None else signal_noise(*noise, measured.interval, balance)
    known = measured.conditions
    conditions = tuple(Condition(name, value, name in known) for name, value in used.items())
    sides = compared(measured), compared(simulated)
    gaps = compare_signals(sides[0].signals, sides[1].signals, levels)
    return Comparison(*sides, gaps, levels, shift, conditions, second)


def _rig(recording: Recording) -> RigConfiguration | None:
    """Return the recording's own rig under its conditions."""
    own = recording.configuration
    return own and apply_conditions(own, recording.conditions)


def _sensors(rig: RigConfiguration | None) -> tuple[float, float] | None:
    """Return the noise of position [m] and pressure [Pa]; None without any, or if unknown."""
    return None if rig is None or rig.sensors.kind == IDEAL else sensor_noise(rig.sensors)


def _all_conditions(rig: RigConfiguration) -> dict[str, float]:
    model = rig.model
    values = model.operation._asdict() | model.gas._asdict()
    return {name: values[name] for name in CONDITIONS}
