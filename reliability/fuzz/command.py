"""``python -m reliability fuzz``: bad input for every reader."""

from __future__ import annotations

import click

from pneu_rig_ros.cli import output
from reliability import figures
from reliability.fuzz import campaign


@click.command()
@click.option('--minutes', type=float, default=10.0, show_default=True, help='how long')
@click.option('--seed', type=int, default=1, show_default=True, help='of the inputs')
@click.option('--keep/--no-keep', default=True, help='write docs/reliability.*')
def fuzz(minutes: float, seed: int, keep: bool) -> None:
    """Try bad input on every reader; exit code 1 if any does not refuse it as it must."""
    runs = campaign.plan(60.0 * minutes)
    with output.progress_bar('bad input', 60.0 * minutes) as progress:
        tallies = list(campaign.carry_out(runs, seed, progress))
    readers = campaign.summary(tallies)
    heads = ('reader', '>tried', '>refused', '>slowest [s]', '>memory [MB]', '>failures')
    rows = [
        (name, f'{row["tried"]:,}', f'{row["refused"]:,}', str(row['slowest_s']),
         str(row['memory_mb']), str(len(row['failures'])))
        for name, row in readers.items()
    ]  # fmt: skip
    output.print_table(output.table(heads, rows))
    failures = [line for row in readers.values() for line in row['failures']]
    for line in failures:
        output.console().print(line)
    if keep:
        figures.keep('fuzz', {'minutes': minutes, 'seed': seed, 'readers': readers},
                     campaign.text(readers, minutes))  # fmt: skip
    if failures:
        raise SystemExit(1)
