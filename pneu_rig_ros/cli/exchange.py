"""Commands between bags and other formats: import and export."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pneu_rig_ros.cli import options, output
from pneu_rig_ros.errors import RigError

if TYPE_CHECKING:
    from pneu_rig_ros.records import Recording

READING = 0.4
"""Share of an import that the reading of a table takes [-]."""


@options.command(
    'pneu-rig import daq.csv --map map.yaml --conditions cond.yaml --out runs/measured',
    'pneu-rig import other_bag --map topics.yaml --cylinder cylinder_2 --out runs/measured',
    name='import',
    after='A mapping names the columns (or their numbers, from 1) and their units:\n'
    '  time: {column: "t [ms]", unit: ms}\n'
    '  position: {column: 5, unit: mm}\n'
    '  pressure_1: {column: p_cap, unit: bar, gauge: true}\n'
    '  u: {column: u, unit: V}\n'
    'for a bag, the topics:\n'
    '  topics: {position: {topic: /axis/joint_states}, pressure_1: /cap/pressure}\n'
    '\b\nConditions are what the signals do not contain:\n'
    '  supply_pressure: 4 bar gauge\n'
    '  load_mass: 0.2 kg\n',
)
@click.argument('source', metavar='FILE|BAG', type=options.PATH)
@options.map_option(required=True, help='which column or topic is which signal, and its unit')
@click.option(
    '--conditions',
    type=options.PATH,
    metavar='YAML',
    help='supply_pressure, load_mass, atmospheric_pressure, rest_time, with units',
)
@click.option(
    '--cylinder',
    metavar='NAME|FILE',
    help='the rig, if known: stored in the bag, so that friction can be estimated',
)
@options.out_directory(required=True, help='bag to create; must not exist')
@options.output_options
def import_(
    source: Path,
    mapping: Path,
    conditions: Path | None,
    cylinder: str | None,
    out: Path,
) -> None:
    """
    Convert measured data (CSV, bags of other rigs) into a bag.

    FILE is a text table with any column names, units, separator and decimal sign; BAG has any
    topics and message types. Everything is converted to SI units and absolute pressures.
    """
    out = options.bag_path(out, 'measured')

    from pneu_rig_ros.records import read_recording
    from pneu_rig_ros.records.conditions import conditions_beside, read_conditions
    from pneu_rig_ros.records.conversion import write_bag

    known = read_conditions(conditions) if conditions else {}
    configuration = options.load(cylinder, {}) if cylinder else None
    with options.directory(out.parent), output.stage_bar() as progress:
        progress('reading', 0.0)
        recording = read_recording(source, mapping, known.get('atmospheric_pressure'))
        writing = f'writing {recording.size} samples'

        def written(samples: float) -> None:
            progress(writing, READING + (1.0 - READING) * samples / recording.size)

        write_bag(recording, out, known, configuration, written)
    missing = max((stamps.size for stamps in recording.missing.values()), default=0)
    samples = recording.size - missing
    values = conditions_beside(out)
    data = {
        'bag': out,
        'source': recording.metadata['source'],
        'signals': list(recording.signals),
        'samples': samples,
        'missing': missing,
        'interval': recording.interval,
        'duration': recording.duration,
        'conditions': values,
        'notes': list(recording.notes),
    }
    if output.as_text(data):
        _print_imported(recording, samples, values, out)


def _print_imported(
    recording: Recording, samples: int, conditions: Mapping[str, float], out: Path
) -> None:
    from pneu_rig_ros.records.conditions import CONDITIONS
    from pneu_rig_ros.records.recording import WHOLE

    texts = [f'{k} {v:g} {CONDITIONS[k].unit}' for k, v in conditions.items()]
    rows = {
        'signals': ', '.join(recording.signals),
        'samples': f'{samples} every {recording.interval * 1e3:g} ms, {recording.duration:.2f} s',
        'conditions': ', '.join(texts) or 'not given; those of the model will be used',
    }
    if absent := [name for name in WHOLE if name not in recording.signals]:
        rows['part of a rig'] = f'no {", ".join(absent)}; only export and diagnose accept it'
    if recording.notes:
        rows['notes'] = '\n'.join(recording.notes)
    output.print_values({**rows, 'bag': out})


@options.command(
    'pneu-rig export runs/BAG --csv',
    'pneu-rig export runs/BAG --parquet --out stroke.parquet',
)
@options.bag_argument
@click.option('--csv', is_flag=True, help='write a CSV file')
@click.option('--parquet', is_flag=True, help='write a Parquet file')
@options.out_file(help='file to write; must not exist  [default: BAG.csv or BAG.parquet]')
@options.output_options
def export(bag: Path, csv: bool, parquet: bool, out: Path | None) -> None:
    """
    Write all signals of a bag as CSV or Parquet.

    There is one row per sample, in SI units. The name of each column ends with its unit, e.g.
    pressure_1_Pa; pressures are absolute.
    """
    if csv == parquet:
        raise RigError('choose one: --csv or --parquet')
    suffix = '.csv' if csv else '.parquet'

    from pneu_rig_ros.records import conversion
    from pneu_rig_ros.records.bag import bag_directory

    directory = bag_directory(bag)
    if out is not None and out.suffix in {'.csv', '.parquet'} - {suffix}:
        raise RigError(f'--out {out}: not a name for --{suffix[1:]}')
    file = out or options.new_file(directory.with_name(directory.name + suffix), '--out')
    columns, metadata = conversion.read_signals(bag)
    if csv:
        conversion.write_csv(columns, file)
    else:
        conversion.write_parquet(columns, metadata, file)
    titles = [column.title for column in columns]
    samples = int(columns[0].values.size)
    if output.as_text({'bag': bag, 'file': file, 'samples': samples, 'columns': titles}):
        output.print_values({'columns': ', '.join(titles), 'samples': samples, 'file': file})
