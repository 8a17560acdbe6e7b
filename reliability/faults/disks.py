"""A disk that fills up, a folder that cannot be written, a bag that is removed."""

from __future__ import annotations

import contextlib
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

from pneu_rig_ros.records import read_recording, repair
from reliability.faults.finding import Finding, NotPossible, Scene
from reliability.live_rig import ProcessRig, until
from reliability.proof import messages, unproven
from reliability.witness import ERROR, Witness

SIZE = 1_500_000
"""Of the disk [byte]: three seconds of the rig."""


MARGIN_NS = 1_000_000_000
"""What had been received this long before the disk was full has to be in the bag [ns]."""

PAUSE = 2.0
"""Longest time without a sample in which the rig is said to go on [s]."""


@contextlib.contextmanager
def small_disk(folder: Path) -> Iterator[Path]:
    """Mount a small disk while the block runs; NotPossible where it is not permitted."""
    folder.mkdir()
    mount = ['mount', '-t', 'tmpfs', '-o', f'size={SIZE}', 'pneu_rig', str(folder)]
    done = subprocess.run(mount, capture_output=True, text=True, check=False)
    if done.returncode:
        raise NotPossible(f'here no small disk can be mounted: {done.stderr.strip()}')
    try:
        yield folder
    finally:
        subprocess.run(['umount', str(folder)], check=True)


def full_disk(scene: Scene) -> Finding:
    """Record to a disk that is too small."""
    kept = scene.folder / 'kept'
    with small_disk(scene.folder / 'disk') as disk:
        with ProcessRig(disk / 'bag') as rig, Witness() as witness:
            told = witness.told('recorder', ERROR, 'No space left on device')
            went_on = witness.hears('joint_states') < PAUSE
            lines = [line for line in rig.log('recorder').splitlines() if 'No space' in line]
            full_ns = round(float(lines[0].split('[')[2].split(']')[0]) * 1e9)
            code = _stopped(rig)
        shutil.copytree(disk / 'bag', kept)
    (kept / 'bag.mcap').rename(kept / 'kept.mcap')
    repair(kept)
    missing = sum(unproven(witness.received, messages(kept), full_ns - MARGIN_NS).values())
    duration = read_recording(kept).duration
    held = not missing and went_on and code == 2 and len(lines) == 1
    last = told.split('; ')[-1]
    return Finding(
        f'full disk ({SIZE / 1e6:.1f} MB)',
        'recording ends, what was written stays and can be read; the rig goes on unrecorded; at '
        'its end the recorder ends with exit code 2',
        'recorder ERROR: cannot write the bag ...: No space left on device; one line in the log',
        f'{duration:.1f} s kept, {missing} messages missing in them; told: "{last}"',
        held,
    )


def _stopped(rig: ProcessRig) -> int | None:
    """Stop the recorder; return its exit code."""
    rig.nodes['recorder'].stop()
    return rig.nodes['recorder'].code


def unwritable_folder(scene: Scene) -> Finding:
    """Record to where nobody may write."""
    (scene.folder / 'file').write_text('')
    lines, codes = [], []
    for path in (Path('/proc/none/bag'), scene.folder / 'file' / 'bag'):
        with ProcessRig(path, only=('recorder',)) as rig:
            until(rig.nodes['recorder'].ended, 'the recorder ends')
            codes.append(rig.nodes['recorder'].code)
            lines += _errors(rig)
    return Finding(
        'folder that cannot be written',
        'the recorder ends with exit code 2 before it has begun',
        'one line: Error: cannot write the bag ...',
        '; '.join(f'"{line}"' for line in lines).replace(str(scene.folder), '/folder'),
        held=codes == [2, 2] and len(lines) == 2,
    )


def removed_bag(scene: Scene) -> Finding:
    """Remove a bag while it is recorded."""
    stage, bag = scene.stage, scene.stage.newest_bag()
    shutil.rmtree(bag)
    stage.witness.listen(1.0)
    went_on = stage.witness.hears('joint_states') < PAUSE
    code, lines = _stopped(stage.rig), _errors(stage.rig)
    stage.rig.start('recorder')
    return Finding(
        'bag removed while it is recorded',
        'the rig goes on; the recorder ends with exit code 2 when it is stopped',
        'one line: Error: cannot write the bag ...',
        '; '.join(f'"{line}"' for line in lines).replace(str(bag.parent), '/folder'),
        held=went_on and code == 2 and len(lines) == 1,
    )


def _errors(rig: ProcessRig) -> list[str]:
    return [line for line in rig.log('recorder').splitlines() if line.startswith('Error: ')]
