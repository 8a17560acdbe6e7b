"""The wall clock is set while the rig runs."""

from __future__ import annotations

import shutil
import subprocess
from itertools import pairwise
from pathlib import Path

import numpy as np

from pneu_rig_ros.records import read_recording
from reliability.faults.finding import Finding, NotPossible, Scene
from reliability.live_rig import ProcessRig
from reliability.proof import missing_samples
from reliability.witness import WARN, Witness

SOURCE = Path(__file__).with_name('wall_clock.c')
"""Shows another wall clock to one process than to the rest of the computer."""

JUMPS = (3600, -3600)
"""By how much the clock is set [s]."""


def environment(folder: Path) -> dict[str, str]:
    """
    Return what makes the wall clock of a process follow the file `clock` in a folder.

    :raises NotPossible: where there is no C compiler
    """
    compiler = shutil.which('cc')
    if compiler is None:
        raise NotPossible('the clock of a process cannot be set without a C compiler, cc')
    library = folder / 'wall_clock.so'
    command = [compiler, '-shared', '-fPIC', '-O2', '-o', str(library), str(SOURCE), '-ldl']
    subprocess.run(command, check=True)
    return {'LD_PRELOAD': str(library), 'WALL_CLOCK_FILE': str(folder / 'clock')}


def _set(file: Path, jump: int) -> None:
    new = file.with_suffix('.new')
    new.write_text(f'{jump:+d}')
    new.replace(file)


def clock_jump(scene: Scene) -> Finding:
    """Set the clock of plant and recorder forth and back by an hour."""
    file = scene.folder / 'clock'
    _set(file, 0)
    faked = environment(scene.folder)
    with (
        ProcessRig(
            scene.folder / 'bag', environment=dict.fromkeys(('plant', 'recorder'), faked)
        ) as rig,
        Witness() as witness,
    ):
        witness.hears('friction')
        for jump in JUMPS:
            _set(file, jump)
            for node in ('plant', 'recorder'):
                witness.told(node, WARN, f'set by {jump:+d}.')
            rig.check()
        witness.listen(1.0)
    record = read_recording(scene.folder / 'bag')
    steps = {b - a for a, b in pairwise(record.stamps.tolist())}
    missing = missing_samples(record)
    late = record.arrival_ns - record.stamps
    held = not missing and steps == {record.interval_ns} and float(np.ptp(late)) < 1e9
    return Finding(
        'wall clock set by an hour, forth and back',
        'stamps and log times go on evenly, as if it had not been set; the next start follows it',
        'plant and recorder WARN: wall clock set by +3600.000 s, stamps go on without it',
        f'{record.position.size} samples, {missing} missing, delays from stamp to log time '
        f'{late.min() * 1e-6:.1f} to {late.max() * 1e-6:.1f} ms',
        held,
    )
