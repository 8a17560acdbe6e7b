"""A table of a whole rig as a record, without a bag in between."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.conditions import format_conditions, with_zero
from pneu_rig_ros.records.importing import COMPLETE, smoothed_velocity
from pneu_rig_ros.records.record import NEVER, Floats, Record, Stamps
from pneu_rig_ros.records.table import Table
from pneu_rig_ros.rig import RigConfiguration
from pneu_rig_ros.rig.valve_drive import valve_voltages

STAMPED = ('joint_states', 'chamber_1/pressure', 'chamber_2/pressure')
"""Topics that lack a sample where the table does."""


def record_of(
    table: Table,
    configuration: RigConfiguration | None = None,
    conditions: Mapping[str, float] | None = None,
) -> Record:
    """
    Return the record that `importing.write_bag` and `read_record` would make of a table.

    :param configuration: the rig, if it is known
    :param conditions: SI; go into the metadata, where `conditions_of` finds them
    :raises RigError: when position or a pressure is missing, or the conditions say another zero
        of gauge pressures than they were counted from
    """
    absent = [name for name in COMPLETE if name not in table]
    if absent:
        raise RigError(f'{table.source}: without {", ".join(absent)} it is a part of a rig only')
    grid = table.grid
    _, signals = grid.filled()
    size = int(grid.sample[-1]) + 1
    arrival = np.full(size, NEVER, dtype=np.int64)
    stamps: Stamps = grid.start_ns + grid.interval_ns * np.arange(size, dtype=np.int64)
    arrival[grid.sample] = stamps[grid.sample]
    missing = stamps[arrival == NEVER]
    interval = grid.interval_ns * 1e-9
    voltage_1, voltage_2 = _voltages(signals, size)
    told = format_conditions(with_zero(conditions or {}, table.atmospheric_pressure))
    return Record(
        start_ns=grid.start_ns,
        interval_ns=grid.interval_ns,
        position=signals['position'],
        velocity=signals.get('velocity', smoothed_velocity(signals['position'], interval)),
        pressure_1=signals['pressure_1'],
        pressure_2=signals['pressure_2'],
        voltage_1=voltage_1,
        voltage_2=voltage_2,
        friction=signals.get('friction', np.full(size, np.nan)),
        arrival_ns=arrival,
        missing=dict.fromkeys(STAMPED, missing),
        configuration=configuration and replace(configuration, interval_ns=grid.interval_ns),
        metadata={'source': Path(table.source).name, **({'conditions': told} if told else {})},
    )


def _voltages(signals: dict[str, Floats], size: int) -> tuple[Floats, Floats]:
    """Return the valve voltages [V]; by Eq. 1 from u, and at rest without that."""
    if 'voltage_1' in signals and 'voltage_2' in signals:
        return signals['voltage_1'], signals['voltage_2']
    u = signals.get('u', np.zeros(size))
    levels, where = np.unique(u, return_inverse=True)
    pairs = np.array([valve_voltages(float(level)) for level in levels])[where]
    return pairs[:, 0].copy(), pairs[:, 1].copy()
