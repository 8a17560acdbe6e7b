"""`pneu-rig import`: measured data in."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.cli import options, output

if TYPE_CHECKING:
    from pneu_rig_ros.records import Recording


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
    from pneu_rig_ros.records.reader import read_recording

    known = read_conditions(conditions) if conditions else {}
    configuration = options.load(cylinder, {}) if cylinder else None
    recording = read_recording(source, mapping, known.get('atmospheric_pressure'))
    bar = output.step_bar('samples', recording.size, quiet=quiet)
    with options.directory(out.parent), bar as progress:
        write_bag(recording, out, known, configuration, progress)
    data = _plain(recording, out)
    if as_json:
        output.print_json(data)
    elif not quiet:
        _print(data)


def _plain(recording: Recording, out: Path) -> dict[str, Any]:
    from pneu_rig_ros.records.conditions import FILE_NAME, read_conditions

    file = out / FILE_NAME
    missing = max((stamps.size for stamps in recording.missing.values()), default=0)
    return {
        'bag': str(out),
        'source': recording.metadata['source'],
        'signals': list(recording.signals),
        'samples': recording.size - missing,
        'missing': missing,
        'interval': recording.interval,
        'duration': recording.duration,
        'conditions': read_conditions(file) if file.exists() else {},
        'notes': list(recording.notes),
    }


def _print(data: dict[str, Any]) -> None:
    from pneu_rig_ros.records.conditions import CONDITIONS
    from pneu_rig_ros.records.recording import WHOLE

    conditions = [f'{name} {value:g} {CONDITIONS[name].unit}'
                  for name, value in data['conditions'].items()]  # fmt: skip
    rows = {
        'signals': ', '.join(data['signals']),
        'samples': f'{data["samples"]} every {data["interval"] * 1e3:g} ms, '
        f'{data["duration"]:.2f} s',
        'conditions': ', '.join(conditions) or 'not given: those of the model will count',
    }
    absent = [name for name in WHOLE if name not in data['signals']]
    if absent:
        rows['part of a rig'] = f'without {", ".join(absent)}; export and read_recording take it'
    for number, note in enumerate(data['notes']):
        rows['note' if number == 0 else f'note {number + 1}'] = note
    output.print_values({**rows, 'bag': data['bag']})
