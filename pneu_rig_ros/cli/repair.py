"""`pneu-rig repair`: a bag whose recorder was killed."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.cli import options, output

if TYPE_CHECKING:
    from pneu_rig_ros.records import RepairReport


@click.command(
    short_help='Mend a bag whose recorder was killed',
    epilog='\b\nExamples:\n'
    '  pneu-rig repair runs/2026-01-31_12-00-00_cylinder_2\n'
    '  for bag in runs/*; do pneu-rig repair "$bag"; done\n',
)
@options.bag_argument
@click.option('--json', 'as_json', is_flag=True, help='print plain data for scripts')
@options.quiet_option
def repair(bag: Path, as_json: bool, quiet: bool) -> None:
    """
    Make a valid bag of one whose recorder was killed.

    Everything up to the last half second is there. The cut file is kept beside the new one. A
    healthy bag is left as it is.
    """
    from pneu_rig_ros.records import repair as mend

    report = mend(bag)
    if as_json:
        output.print_json(plain(report))
    elif not quiet:
        _print(report)


def plain(report: RepairReport) -> dict[str, Any]:
    """Return what was done as plain data."""
    cut = report.cut_file
    return {**asdict(report), 'path': str(report.path), 'cut_file': str(cut) if cut else None}


def _print(report: RepairReport) -> None:
    terminal = output.console()
    size = f'{report.messages} messages, {report.duration:.2f} s'
    if not report.repaired:
        terminal.print(f'{report.path} is healthy ({size}); nothing changed')
        return
    terminal.print(f'{report.path} is repaired: {size}')
    if not report.configuration_found:
        lost = (
            'was lost with a damaged chunk' if report.configuration_lost else 'is not in the bag'
        )
        terminal.print(f'the rig configuration {lost}; friction cannot be estimated')
    if report.damaged_chunks:
        chunks = 'chunk is' if report.damaged_chunks == 1 else 'chunks are'
        terminal.print(f'{report.damaged_chunks} damaged {chunks} left out')
    terminal.print(f'the cut file is kept: {report.cut_file}', style='dim')
