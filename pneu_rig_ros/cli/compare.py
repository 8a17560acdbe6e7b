"""`pneu-rig compare`: a measured bag beside a model or another bag."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pneu_rig_ros.cli import options, output
from pneu_rig_ros.errors import RigError

if TYPE_CHECKING:
    from pneu_rig_ros.analysis.comparison import Comparison


@click.command(
    short_help='A measured bag beside a model or another bag',
    epilog='\b\nExamples:\n'
    '  pneu-rig compare runs/measured --model cylinder_2\n'
    '  pneu-rig compare runs/measured --model improved.yaml --out comparison.html\n'
    '  pneu-rig compare runs/monday --model runs/tuesday --json | jq .signals.position\n',
)
@click.argument('measured', type=click.Path(path_type=Path))
@click.option(
    '--model',
    required=True,
    metavar='NAME|FILE|BAG',
    help='a cylinder, a YAML file of your own, or another bag',
)
@click.option(
    '--shift',
    type=options.FINITE,
    metavar='SECOND',
    help='by how much the second bag is late  [default: by the onset of the command]',
)
@click.option('--out', type=click.Path(path_type=Path), metavar='FILE', help='write an HTML page')
@click.option('--json', 'as_json', is_flag=True, help='print plain data for scripts')
@click.option('--quiet', is_flag=True, help='print nothing but errors')
def compare(
    measured: Path, model: str, shift: float | None, out: Path | None, as_json: bool, quiet: bool
) -> None:
    """
    Lay a measured bag beside a model of its rig, or beside another bag.

    The model starts where the bag starts and gets its conditions and its recorded voltages; two
    bags are aligned by the onset of the command. Tells for every signal how far they are
    apart, in its unit and in multiples of the sensor noise, and lists the stick-slip cycles.
    """
    page = options.new_file(out, '--out') if out else None
    comparison = _compare(measured, model, shift)
    if page:
        _write(page, comparison, quiet)
    if as_json:
        files = {'page': str(page)} if page else {}
        output.print_json({**comparison.to_dict(), **files})
    elif not quiet:
        _print(comparison, page)


def _compare(measured: Path, model: str, shift: float | None) -> Comparison:
    from pneu_rig_ros.analysis.comparison import compare_with_bag, compare_with_model

    if Path(model).is_dir() or model.endswith('.mcap'):
        return compare_with_bag(measured, model, shift)
    if shift is not None:
        raise RigError('--shift is for two bags; a model starts with the bag')
    return compare_with_model(measured, options.load(model, {}), model)


def _write(page: Path, comparison: Comparison, quiet: bool) -> None:
    from pneu_rig_ros.report.comparison_page import FIGURES, write_page

    with output.step_bar('figures', FIGURES, quiet=quiet) as progress:
        write_page(page, comparison, progress)


SIGNALS = ('signal', '>RMSE', '>largest', '>bias', 'unit', '>sensor noise', '>RMSE / noise')
"""Heads of the table that is printed; '>' is for numbers."""


def _print(comparison: Comparison, page: Path | None) -> None:
    from pneu_rig_ros.report.comparison_page import condition_texts, event_rows, signal_rows

    terminal = output.console()
    signals = [(row.signal, row.rmse, row.largest, row.bias, row.unit, row.noise, row.multiple)
               for row in signal_rows(comparison)]  # fmt: skip
    output.print_table(output.table(SIGNALS, signals))
    terminal.print()
    heads = '', '>measured', f'>{comparison.second}'
    output.print_table(output.table(heads, event_rows(comparison)))
    terminal.print()
    sides = [side.recording.name for side in (comparison.measured, comparison.simulated)]
    rows = {'measured': sides[0], comparison.second: sides[1]}
    rows['conditions'] = f',\n{"":<{output.NAME_WIDTH}}'.join(condition_texts(comparison)) or '-'
    if comparison.shift:
        rows['shifted by'] = f'{-comparison.shift:.3f} s'
    output.print_values(rows | ({'page': str(page)} if page else {}))
