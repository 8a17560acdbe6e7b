"""A disk that fills up, a folder that cannot be written, a bag that is removed."""

from __future__ import annotations

import contextlib
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

from pneu_rig_ros.records import read_record, repair
from reliability.faults.finding import Finding, NotPossible, Scene
from reliability.live_rig import ProcessRig, until
from reliability.proof import messages, unproven
from reliability.witness import ERROR, Witness

SIZE = 2_500_000
"""Of the disk [byte]: four seconds of the rig."""


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
            samples = witness.received['joint_states']
            recorded_until = samples[-1].time_ns - 2_500_000_000  # diagnostics come once a second
            witness.listen(0.5)
            went_on = witness.hears('joint_states') < 1.0
            lines = [line for line in rig.log('recorder').splitlines() if 'No space' in line]
            code = _stopped(rig)
        shutil.copytree(disk / 'bag', kept)
    (kept / 'bag.mcap').rename(kept / 'kept.mcap')
    repair(kept)
    missing = sum(unproven(witness.received, messages(kept), recorded_until).values())
    duration = read_record(kept).duration
    held = not missing and went_on and code == 2 and len(lines) == 1
    return Finding(
        f'full disk ({SIZE / 1e6:.1f} MB)',
        'recording ends, what was written stays and can be read; the rig goes on unrecorded; at '
        'its end the recorder ends with exit code 2',
        'recorder ERROR: cannot write the bag ...: No space left on device; one line in the log',
        f'{duration:.1f} s kept, {missing} messages missing in them; told: "{told[-45:]}"',
        held,
    )


def _stopped(rig: ProcessRig) -> int | None:
    """Stop the recorder; return its exit code."""
    rig.nodes['recorder'].stop()
    return rig.nodes['recorder'].code


def unwritable_folder(scene: Scene) -> Finding:
    """Record to where nobody may write, and remove a bag while it is recorded."""
    (scene.folder / 'file').write_text('')
    lines, codes = [], []
    for path in (Path('/proc/none/bag'), scene.folder / 'file' / 'bag'):
        with ProcessRig(path, only=('recorder',)) as rig:
            recorder = rig.nodes['recorder']
            until(recorder.ended, 'the recorder ends')
            codes.append(recorder.code)
            lines.append(_errors(rig))
    with ProcessRig(scene.folder / 'bag') as rig, Witness() as witness:
        witness.hears('friction')
        witness.listen(1.0)
        shutil.rmtree(scene.folder / 'bag')
        witness.listen(1.0)
        went_on = witness.hears('joint_states') < 1.0
        codes.append(_stopped(rig))
        lines.append(_errors(rig))
    held = codes == [2, 2, 2] and all(len(told) == 1 for told in lines) and went_on
    return Finding(
        'folder that cannot be written; bag removed while it is recorded',
        'the recorder ends with exit code 2, at once or at its end; the rig goes on',
        'one line: Error: cannot write the bag ...',
        '; '.join(f'"{told[0].removeprefix("Error: ")}"' for told in lines if told).replace(
            str(scene.folder), '/folder'
        ),
        held,
    )


def _errors(rig: ProcessRig) -> list[str]:
    return [line for line in rig.log('recorder').splitlines() if line.startswith('Error: ')]
