"""A measured bag beside a model of its rig, or beside another bag."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pneu_rig_ros.analysis.alignment import common, shift_between
from pneu_rig_ros.analysis.comparison import (
    Events,
    Run,
    SignalGap,
    compare_runs,
    sensor_noise,
    signal_noise,
)
from pneu_rig_ros.analysis.rerun import rerun
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import Recording, read_recording
from pneu_rig_ros.records.conditions import (
    CONDITIONS,
    apply_conditions,
    conditions_of,
)
from pneu_rig_ros.records.plausible import check_plausible, signals_of
from pneu_rig_ros.rig import RigConfiguration
from pneu_rig_ros.rig.sensors import IDEAL


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

    measured: Run
    simulated: Run
    gaps: Mapping[str, SignalGap]
    noise: Mapping[str, float]
    shift: float
    conditions: tuple[Condition, ...]
    second: str

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON, SI units."""
        return {
            'measured': self.measured.name,
            'model': self.simulated.name,
            'samples': int(self.measured.position.size),
            'interval': self.measured.interval,
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
    record = read_recording(bag)
    if not record.counts.get('valve_voltages'):
        raise RigError(f'{bag}: no valve_voltages in it, so that no model can be driven; '
                       'import it with u, or voltage_1 and voltage_2')  # fmt: skip
    known = conditions_of(bag, record)
    model = apply_conditions(configuration, known)
    check_plausible(bag, signals_of(record), model)
    measured = Run.of(str(bag), record, _rig(record, known) or model)
    simulated = rerun(record, model, name)
    used = _all_conditions(model)
    noise = _sensors(record, configuration)
    return _compared(measured, simulated, noise, 0.0, known, used, 'simulated')


def compare_with_bag(
    bag: Path | str, other: Path | str, shift: float | None = None
) -> Comparison:  # fmt: skip
    """
    Compare a bag with another one.

    :param shift: by how much the second one's time is late [s]; found from the onset of the
        command when not given
    :raises RigError: when one cannot be read, or they do not overlap
    """
    records = read_recording(bag), read_recording(other)
    known = [conditions_of(path, r) for path, r in zip((bag, other), records, strict=True)]
    rigs = [_rig(r, k) for r, k in zip(records, known, strict=True)]
    first, second = (
        Run.of(str(path), record, rig or rigs[0] or rigs[1])
        for path, record, rig in zip((bag, other), records, rigs, strict=True)
    )
    late = shift_between(*records) if shift is None else shift
    aligned = common(first, second, late)
    used = _all_conditions(rigs[0]) if rigs[0] else known[0]
    noise = _sensors(records[0], rigs[0] or rigs[1])
    return _compared(*aligned, noise, late, known[0], used, 'second bag')


def _compared(
    measured: Run, simulated: Run, noise: tuple[float, float] | None, shift: float,
    known: Mapping[str, float], used: Mapping[str, float], second: str,
) -> Comparison:  # fmt: skip
    levels = {} if noise is None else signal_noise(*noise, measured.interval, measured.balance)
    conditions = tuple(Condition(name, value, name in known) for name, value in used.items())
    gaps = compare_runs(measured, simulated, levels)
    return Comparison(measured, simulated, gaps, levels, shift, conditions, second)


def _rig(record: Recording, conditions: Mapping[str, float]) -> RigConfiguration | None:
    """Return the record's own rig under its conditions."""
    return record.configuration and apply_conditions(record.configuration, conditions)


def _sensors(record: Recording, other: RigConfiguration | None) -> tuple[float, float] | None:
    """Return the noise of position [m] and pressure [Pa]; None without any, or if unknown."""
    rig = record.configuration or other
    return None if rig is None or rig.sensors.kind == IDEAL else sensor_noise(rig.sensors)


def _all_conditions(rig: RigConfiguration) -> dict[str, float]:
    model = rig.model
    values = model.operation._asdict() | model.gas._asdict()
    return {name: values[name] for name in CONDITIONS}
