"""`pneu-rig export`: a bag as CSV or Parquet."""

from __future__ import annotations

from pathlib import Path

import click

from pneu_rig_ros.cli import options, output
from pneu_rig_ros.errors import RigError


@click.command(
    short_help='All signals of a bag as CSV or Parquet',
    epilog='\b\nExamples:\n'
    '  pneu-rig export runs/BAG --csv\n'
    '  pneu-rig export runs/BAG --parquet --out stroke.parquet\n',
)
@options.bag_argument
@click.option('--csv', is_flag=True, help='write a CSV file')
@click.option('--parquet', is_flag=True, help='write a Parquet file')
@click.option(
    '--out',
    type=click.Path(path_type=Path),
    metavar='FILE',
    help='file to write; must not exist  [default: BAG.csv or BAG.parquet, beside the bag]',
)
@click.option('--json', 'as_json', is_flag=True, help='print plain data for scripts')
@click.option('--quiet', is_flag=True, help='print nothing but errors')
def export(
    bag: Path, csv: bool, parquet: bool, out: Path | None, as_json: bool, quiet: bool
) -> None:
    """
    Write all signals of a bag on its sampling grid, in SI units.

    The unit of each column stands in its name, e.g. pressure_1_Pa; pressures are absolute.
    """
    kind = _kind(csv, parquet)

    from pneu_rig_ros.records import exporting
    from pneu_rig_ros.records.bag import bag_directory

    directory = bag_directory(bag)
    if out is not None and out.suffix in {'.csv', '.parquet'} - {f'.{kind}'}:
        raise RigError(f'--out {out}: is not a name for --{kind}')
    file = options.new_file(out or directory.with_name(f'{directory.name}.{kind}'), '--out')
    signals = exporting.read_signals(bag)
    write = exporting.write_csv if kind == 'csv' else exporting.write_parquet
    write(signals, file)
    columns = [column.title for column in signals.columns]
    samples = int(signals.columns[0].values.size)
    if as_json:
        output.print_json({'bag': str(bag), 'file': str(file), 'samples': samples,
                           'columns': columns})  # fmt: skip
    elif not quiet:
        output.print_values({'columns': ', '.join(columns), 'samples': str(samples),
                             'file': str(file)})  # fmt: skip


def _kind(csv: bool, parquet: bool) -> str:
    if csv == parquet:
        raise RigError('say which one: --csv or --parquet')
    return 'csv' if csv else 'parquet'
