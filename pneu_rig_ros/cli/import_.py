"""`pneu-rig import`: measured data in."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.cli import options, output

if TYPE_CHECKING:
    from pneu_rig_ros.records.grid import Grid
    from pneu_rig_ros.records.table import Table


@click.command(
    'import',
    short_help='Measured data of any rig (CSV, foreign bag) into a bag',
    epilog='\b\nExamples:\n'
    '  pneu-rig import daq.csv --map map.yaml --conditions cond.yaml --out runs/measured\n'
    '  pneu-rig import foreign_bag --map topics.yaml --cylinder cylinder_2 --out runs/measured\n'
    '\b\nA mapping names the columns (or their numbers, from 1) and units:\n'
    '  time: {column: "t [ms]", unit: ms}\n'
    '  position: {column: 5, unit: mm}\n'
    '  pressure_1: {column: p_cap, unit: bar, gauge: true}\n'
    '  u: {column: u, unit: V}\n'
    'of a bag, the topics:\n'
    '  topics: {position: {topic: /axis/joint_states}, pressure_1: /cap/pressure}\n'
    '\b\nConditions are what the signals do not say:\n'
    '  supply_pressure: 4 bar gauge\n'
    '  load_mass: 0.2 kg\n',
)
@click.argument('source', metavar='FILE|BAG', type=click.Path(path_type=Path))
@click.option(
    '--map',
    'mapping',
    type=click.Path(path_type=Path),
    required=True,
    metavar='YAML',
    help='which column or topic is what, and its unit',
)
@click.option(
    '--conditions',
    type=click.Path(path_type=Path),
    metavar='YAML',
    help='supply_pressure, load_mass, atmospheric_pressure, rest_time, with units',
)
@click.option(
    '--cylinder',
    metavar='NAME|FILE',
    help='the rig, if it is known: goes into the bag, so that friction can be estimated',
)
@click.option(
    '--out',
    type=click.Path(path_type=Path),
    required=True,
    metavar='DIRECTORY',
    help='bag to create; must not exist',
)
@click.option('--json', 'as_json', is_flag=True, help='print plain data for scripts')
@click.option('--quiet', is_flag=True, help='print nothing but errors')
def import_(
    source: Path,
    mapping: Path,
    conditions: Path | None,
    cylinder: str | None,
    out: Path,
    as_json: bool,
    quiet: bool,
) -> None:
    """
    Turn measured data into a bag of the recorder's form.

    FILE is a text table with any column names, units, separator and decimal sign; BAG one with
    any topics and message types. Everything is converted to SI units and absolute pressures.
    """
    out = options.bag_path(out, 'measured')

    from pneu_rig_ros.records.conditions import read_conditions
    from pneu_rig_ros.records.importing import write_bag
    from pneu_rig_ros.records.table import read_table

    known = read_conditions(conditions) if conditions else {}
    configuration = options.load(cylinder, {}) if cylinder else None
    table = read_table(source, mapping, known.get('atmospheric_pressure'))
    bar = output.step_bar('samples', table.time.size, quiet=quiet)
    with options.directory(out.parent), bar as progress:
        grid = write_bag(table, out, known, configuration, progress)
    if as_json:
        output.print_json(_plain(table, grid, out))
    elif not quiet:
        _print(table, grid, out)


def _plain(table: Table, grid: Grid, out: Path) -> dict[str, Any]:
    from pneu_rig_ros.records.conditions import FILE_NAME, read_conditions

    file = out / FILE_NAME
    return {
        'bag': str(out),
        'source': table.source,
        'signals': list(table.signals),
        'samples': int(grid.sample.size),
        'missing': grid.missing,
        'interval': grid.interval_ns * 1e-9,
        'duration': int(grid.sample[-1]) * grid.interval_ns * 1e-9,
        'conditions': read_conditions(file) if file.exists() else {},
        'notes': [*table.notes, *([grid.note] if grid.note else [])],
    }


def _print(table: Table, grid: Grid, out: Path) -> None:
    from pneu_rig_ros.records.conditions import CONDITIONS
    from pneu_rig_ros.records.importing import COMPLETE

    data = _plain(table, grid, out)
    conditions = [f'{name} {value:g} {CONDITIONS[name].unit}'
                  for name, value in data['conditions'].items()]  # fmt: skip
    rows = {
        'signals': ', '.join(table.signals),
        'samples': f'{grid.sample.size} every {grid.interval_ns * 1e-6:g} ms, '
        f'{data["duration"]:.2f} s',
        'conditions': ', '.join(conditions) or 'not given: those of the model will count',
    }
    absent = [name for name in COMPLETE if name not in table]
    if absent:
        rows['part of a rig'] = f'without {", ".join(absent)}; export and read_table take it'
    for number, note in enumerate(data['notes']):
        rows['note' if number == 0 else f'note {number + 1}'] = note
    output.print_values({**rows, 'bag': str(out)})
