"""`pneu-rig import` of large tables: time that grows with the rows, and bounded memory."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

pytestmark = pytest.mark.long

FEW, MANY = 1_000_000, 5_000_000
MAPPING = """
time: {column: t, unit: ms}
position: {column: x, unit: mm}
pressure_1: {column: p1, unit: bar}
pressure_2: {column: p2, unit: bar}
"""


class Cost(NamedTuple):
    """Of an import: time [s], processor time [s] and largest memory [MB]."""

    elapsed: float
    seconds: float
    megabytes: float


def cost(folder: Path, rows: int) -> Cost:
    """Import a table of so many rows in a process of its own."""
    numbers = np.arange(float(rows))
    position = 60.0 + 20.0 * np.sin(2e-4 * numbers)
    pressure = 2.0 + np.sin(3e-4 * numbers)
    table = np.column_stack([numbers, position, pressure, 4.0 - pressure])
    np.savetxt(folder / f'{rows}.csv', table, '%.8g', ',', header='t,x,p1,p2', comments='')
    (folder / 'map.yaml').write_text(MAPPING)
    words = ['import', f'{rows}.csv', '--map', 'map.yaml', '--out', f'bag_{rows}', '--quiet']
    start = time.monotonic()
    process = subprocess.Popen([sys.executable, '-m', 'pneu_rig_ros.cli', *words], cwd=folder)
    _, status, used = os.wait4(process.pid, 0)
    elapsed = time.monotonic() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0
    shutil.rmtree(folder / f'bag_{rows}')  # up to 2 GB
    return Cost(elapsed, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024.0)


def test_time_is_linear_and_memory_bounded(tmp_path: Path) -> None:
    """Processor time, which other work on the machine changes least."""
    cost(tmp_path, 1000)  # caches of the first start
    start, few, many = (cost(tmp_path, rows) for rows in (1001, FEW, MANY))
    growth = (many.seconds - start.seconds) / (few.seconds - start.seconds)
    print(f'\n{few} for {FEW} rows, {many} for {MANY}, {start} to start: {growth:.2f} times')
    assert growth < 1.3 * MANY / FEW
    assert few.megabytes < 450.0
    assert many.megabytes < 1000.0
