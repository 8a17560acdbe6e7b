"""`pneu-rig view`: a bag as an interactive page."""

from __future__ import annotations

from pathlib import Path

import click

from pneu_rig_ros.cli import options, output


@click.command(
    short_help='A bag as an interactive HTML page',
    epilog='\b\nExamples:\n'
    '  pneu-rig view runs/BAG                       writes BAG.html beside the bag\n'
    '  pneu-rig view runs/BAG --out stroke.html\n'
    '  pneu-rig view runs/BAG --from 12 --to 14.5   every sample of a part of a long bag\n',
)
@options.bag_argument
@click.option(
    '--out',
    type=click.Path(path_type=Path),
    metavar='FILE',
    help='page to write; must not exist  [default: BAG.html]',
)
@click.option(
    '--from', 'start', type=options.FINITE, metavar='SECOND', help='first second to show'
)
@click.option('--to', 'stop', type=options.FINITE, metavar='SECOND', help='last second to show')
@click.option('--quiet', is_flag=True, help='print nothing but errors')
def view(
    bag: Path, out: Path | None, start: float | None, stop: float | None, quiet: bool
) -> None:
    """
    Write a bag as an interactive page that needs nothing else, not even the network.

    Signals to zoom into, the modes of motion and the stick-slip cycles marked, and the cylinder
    as it is at the cursor's time.
    """
    title = bag.stem if bag.suffix == '.mcap' else bag.name
    page = options.new_file(out or bag.with_name(f'{title}.html'), '--out')

    from pneu_rig_ros.records import read_recording
    from pneu_rig_ros.report.view_page import write_view

    write_view(page, read_recording(bag), title, start, stop)
    if not quiet:
        output.print_values({'page': str(page)})
