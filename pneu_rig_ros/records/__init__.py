"""
Validated, time-aligned signals with units; rosbag2 directories with MCAP storage in and out.

One function reads them all: a bag of any rig, or a text table, into a `Recording`.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pneu_rig_ros.errors import RigError, prefixed, printable
from pneu_rig_ros.records.bag import folder_of
from pneu_rig_ros.records.conditions import conditions_beside, conditions_of, with_zero
from pneu_rig_ros.records.description import configuration_in
from pneu_rig_ros.records.grid import Columns, to_grid
from pneu_rig_ros.records.mapped_bag import read_mapped_bag
from pneu_rig_ros.records.mapping import read_mapping
from pneu_rig_ros.records.own_bag import read_own_bag
from pneu_rig_ros.records.recording import NEVER, Recording
from pneu_rig_ros.records.repair import RepairReport, repair
from pneu_rig_ros.records.text_table import read_columns
from pneu_rig_ros.records.units import DEFAULT_ATMOSPHERE
from pneu_rig_ros.records.writer import BagWriter

__all__ = ['BagWriter', 'Recording', 'RepairReport', 'is_bag', 'read_recording', 'repair']

UNPROTECTED = 'no checksums: changed bits would not be noticed'


def read_recording(
    path: Path | str,
    mapping: Path | str | Mapping[str, Any] | None = None,
    atmospheric_pressure: float | None = None,
) -> Recording:
    """
    Read a bag or a text table.

    :param path: a bag's directory or a file in it, or a text file
    :param mapping: where the signals are: a YAML file, or what it would hold. A bag with the
        topics of this project needs none
    :param atmospheric_pressure: zero of gauge pressures [Pa] where neither the mapping nor the
        conditions beside the data give it; default 1e5 Pa
    :raises RigError: for an error in the file or in the mapping
    """
    path = Path(path)
    known = read_mapping(mapping) if mapping is not None else None
    if known is None:
        if path.exists() and not is_bag(path):
            raise RigError(
                f'{path} is not a bag; pass the bag directory, or turn it into one: pneu-rig '
                'import; a mapping must say which column is what'
            )
        # The recorder writes MCAP: another storage is that of another recorder.
        others = path.suffix in ('.db3', '.bag') or (path.is_dir() and any(path.glob('*.db3')))
        if not others and (recording := read_own_bag(path, _run_name(path))) is not None:
            return recording
    given = (
        known.atmospheric_pressure if known else None,
        conditions_beside(path).get('atmospheric_pressure'),
        atmospheric_pressure,
    )
    zero = next((value for value in given if value is not None), DEFAULT_ATMOSPHERE)
    if known is None or is_bag(path):
        columns = read_mapped_bag(path, known, zero)
    else:
        columns = read_columns(path, known, zero)
    return _on_grid(path, columns, zero)


def is_bag(path: Path) -> bool:
    """Return whether a path is that of a bag, or of a file in one, and not of a text table."""
    return folder_of(path) is not None or path.suffix == '.bag'


def _run_name(path: Path) -> str:
    """Return what to call the run in a bag's directory, in a file of one or in a text table."""
    folder = folder_of(path)
    return path.stem if folder is None else folder.resolve().name


def _on_grid(path: Path, columns: Columns, zero: float) -> Recording:
    """Return columns on the uniform grid of their own, with the conditions of their run."""
    configuration = configuration_in(columns.metadata)
    known = conditions_of(path, configuration, columns.metadata)
    surroundings = zero if columns.gauge else None
    with prefixed(path):
        stamps, recorded, signals, changes = to_grid(columns)
        conditions = with_zero(known, surroundings)
    return Recording(
        _run_name(path),
        int(stamps[0]),
        int(stamps[1] - stamps[0]),
        signals,
        missing=dict.fromkeys(signals, stamps[~recorded]),
        arrival_ns=np.where(recorded, stamps, NEVER),
        metadata={'source': printable(str(path)), **columns.metadata},
        configuration=configuration,
        protected=columns.protected,
        notes=(*columns.notes, *changes, *(() if columns.protected else (UNPROTECTED,))),
        conditions=conditions,
        atmospheric_pressure=surroundings,
    )
