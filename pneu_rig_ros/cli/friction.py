"""`pneu-rig friction`: Eq. 2 offline."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.cli import options, output

if TYPE_CHECKING:
    from pneu_rig_ros.analysis.friction import Floats
    from pneu_rig_ros.analysis.motion import Cycle
    from pneu_rig_ros.records import Recording


@click.command(
    short_help='Friction force of a bag by Eq. 2, offline',
    epilog='\b\nExamples:\n'
    '  pneu-rig friction runs/BAG\n'
    '  pneu-rig friction runs/BAG --csv friction.csv --png stroke.png\n'
    '  pneu-rig friction runs/BAG --json | jq .cycles[0].peak_friction\n',
)
@options.bag_argument
@click.option('--csv', type=click.Path(path_type=Path), metavar='FILE', help='write the signals')
@click.option('--png', type=click.Path(path_type=Path), metavar='FILE', help='draw the stroke')
@click.option('--json', 'as_json', is_flag=True, help='print plain data for scripts')
def friction(bag: Path, csv: Path | None, png: Path | None, as_json: bool) -> None:
    """
    Estimate the friction force of a bag by Eq. 2, offline.

    With the zero-phase 32 Hz filter of the paper. Prints the stick-slip cycles; friction is that
    of cylinder and guide together.
    """
    csv = options.new_file(csv, '--csv') if csv else None
    png = options.new_picture(png)

    from pneu_rig_ros.analysis.friction import friction_of
    from pneu_rig_ros.analysis.motion import cycles_of
    from pneu_rig_ros.records import read_recording

    recording = read_recording(bag)
    force = friction_of(recording)
    cycles = cycles_of(recording, force)
    files: dict[str, Path] = {}
    if csv:
        files['csv'] = _write_csv(csv, recording, force)
    if png:
        from pneu_rig_ros.report.figure import draw_stroke

        files['picture'] = draw_stroke(recording, png)
    if as_json:
        output.print_json(_plain(bag, force, cycles, files))
    else:
        _print(force, cycles, files)


def _write_csv(path: Path, recording: Recording, force: Floats) -> Path:
    import numpy as np

    from pneu_rig_ros.errors import RigError

    head = 'time_s,position_m,velocity_m_per_s,pressure_1_Pa,pressure_2_Pa,friction_N'
    signals = (recording.time, recording.position, recording.velocity, recording.pressure_1,
               recording.pressure_2, force)  # fmt: skip
    try:
        np.savetxt(path, np.column_stack(signals), '%.9g', ',', header=head, comments='')
    except OSError as error:
        raise RigError(f'cannot write {path}: {error.strerror}') from error
    return path


def _plain(
    bag: Path, force: Floats, cycles: list[Cycle], files: dict[str, Path]
) -> dict[str, Any]:
    return {
        'bag': str(bag),
        **{name: str(path) for name, path in files.items()},
        'mean_friction': float(force.mean()),
        'peak_friction': max((cycle.peak_friction for cycle in cycles), default=None),
        'cycles': [cycle._asdict() for cycle in cycles],
    }


def _print(force: Floats, cycles: list[Cycle], files: dict[str, Path]) -> None:
    from rich import box
    from rich.table import Table

    terminal = output.console()
    if cycles:
        table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
        heads = ('cycle', 'breakaway [s]', 'dwell [s]', 'slip [mm]', 'peak friction [N]')
        for head in heads:
            table.add_column(head, justify='right')
        for number, cycle in enumerate(cycles, start=1):
            table.add_row(
                str(number),
                f'{cycle.breakaway_time:.3f}',
                f'{cycle.dwell:.3f}',
                f'{cycle.slip * 1e3:.2f}',
                f'{cycle.peak_friction:.2f}',
            )
        terminal.print(table)
    else:
        terminal.print('no stick-slip cycle: the piston did not break away')
    terminal.print()
    rows = {'mean friction': f'{force.mean():.2f} N'}
    output.print_values(rows | {name: str(path) for name, path in files.items()})
