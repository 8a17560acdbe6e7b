"""`pneu-rig repair`: a bag whose recorder was killed."""

from __future__ import annotations

from pathlib import Path

import click

from pneu_rig_ros.cli import options, output


@click.command(
    short_help='Mend a bag whose recorder was killed',
    epilog='\b\nExamples:\n'
    '  pneu-rig repair runs/2026-01-31_12-00-00_cylinder_2\n'
    '  for bag in runs/*; do pneu-rig repair "$bag"; done\n',
)
@options.bag_argument
def repair(bag: Path) -> None:
    """
    Make a valid bag of one whose recorder was killed.

    Everything up to the last half second is there. The cut file is kept beside the new one. A
    healthy bag is left as it is.
    """
    from pneu_rig_ros.records import repair as mend

    report = mend(bag)
    terminal = output.console()
    size = f'{report.messages} messages, {report.duration:.2f} s'
    if not report.repaired:
        terminal.print(f'{report.path} is healthy ({size}); nothing changed')
        return
    terminal.print(f'{report.path} is repaired: {size}')
    if not report.configuration_found:
        terminal.print('the rig configuration was not recorded; friction cannot be estimated')
    terminal.print(f'the cut file is kept: {report.cut_file}', style='dim')
