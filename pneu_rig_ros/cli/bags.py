"""Commands on bags: info, view, friction, repair, import and export."""

from dataclasses import asdict
from pathlib import Path

import click

from pneu_rig_ros.cli import options, output
from pneu_rig_ros.errors import RigError

READING = 0.4
"""Share of an import that the reading of a table takes [-]."""


@click.command(
    epilog=options.examples(
        'pneu-rig info runs/2026-01-31_12-00-00_cylinder_2',
        'pneu-rig info runs/BAG --json | jq .lost',
    ),
)
@options.bag_argument
@options.json_option
def info(bag: Path, as_json: bool) -> None:
    """Show what a bag contains: rig, topics, timing, cycles."""
    from pneu_rig_ros.analysis.summary import summarise
    from pneu_rig_ros.records import read_recording
    from pneu_rig_ros.records.topics import TOPICS

    recording = read_recording(bag)
    summary = summarise(recording)
    keys = ('package_version', 'git_revision')
    version, revision = origin = [recording.metadata.get(key, 'unknown') for key in keys]
    if as_json:
        data = {'messages': dict(recording.counts), 'checksums': recording.protected}
        origins = dict(zip(keys, origin, strict=True))
        output.print_json({'bag': bag, **origins, **data, **summary.to_dict()})
        return
    output.print_summary(summary, {'bag': bag})
    checksums = 'of every message' if recording.protected else 'none: damage would go unnoticed'
    written_by = f'pneu_rig_ros {version}, revision {revision}'
    output.print_values({'written by': written_by, 'checksums': checksums})
    output.console().print()
    rows = [
        (
            topic,
            TOPICS[topic].type,
            str(count),
            str(summary.timing.lost.get(topic, output.UNKNOWN)),
        )
        for topic, count in recording.counts.items()
    ]
    output.print_table(('topic', 'type', '>messages', '>lost'), rows)


@click.command(
    epilog=options.examples(
        'pneu-rig view runs/BAG                       writes BAG.html beside the bag',
        'pneu-rig view runs/BAG --out stroke.html',
        'pneu-rig view runs/BAG --from 12 --to 14.5   every sample of a part of a long bag',
    ),
)
@options.bag_argument
@options.out_file(help='page to write; must not exist  [default: BAG.html]')
@options.seconds_option('--from', 'start', help='start of the part to show')
@options.seconds_option('--to', 'stop', help='end of the part to show')
@options.quiet_option
def view(
    bag: Path, out: Path | None, start: float | None, stop: float | None, quiet: bool
) -> None:
    """
    Write a bag as an interactive HTML page that works offline.

    It shows the signals, which can be zoomed, with the modes of motion and the stick-slip cycles
    marked, and the cylinder at the time of the cursor.
    """
    title = bag.stem if bag.suffix == '.mcap' else bag.name
    page = out or options.new_file(bag.with_name(f'{title}.html'), '--out')

    from pneu_rig_ros.records import read_recording
    from pneu_rig_ros.report.view_page import write_view

    write_view(page, read_recording(bag), title, start, stop)
    if not quiet:
        output.print_values({'page': page})


@click.command(
    epilog=options.examples(
        'pneu-rig friction runs/BAG',
        'pneu-rig friction runs/BAG --csv friction.csv --png stroke.png',
        'pneu-rig friction runs/BAG --json | jq .cycles[0].peak_friction',
    ),
)
@options.bag_argument
@click.option('--csv', type=options.NewFile(), metavar='FILE', help='write the signals as CSV')
@options.png_option
@options.json_option
def friction(bag: Path, csv: Path | None, png: Path | None, as_json: bool) -> None:
    """
    Estimate the friction force of a bag, offline.

    Uses Eq. 2 with the zero-phase 32 Hz filter of the paper, and prints the stick-slip cycles. The
    force is that of cylinder and guide together.
    """
    from pneu_rig_ros.analysis.friction import friction_of
    from pneu_rig_ros.analysis.motion import cycles_of
    from pneu_rig_ros.records import read_recording
    from pneu_rig_ros.records.conversion import Signals, columns_of, write_csv

    recording = read_recording(bag)
    force = friction_of(recording)
    cycles = cycles_of(recording, force)
    files: dict[str, Path] = {}
    if csv:
        derived = recording.with_signals(velocity=recording.velocity, friction=force)
        names = ('position', 'velocity', 'pressure_1', 'pressure_2', 'friction')
        columns = columns_of(derived, names)
        files['csv'] = write_csv(Signals(columns, {}), csv)
    if png:
        from pneu_rig_ros.report.figure import draw_stroke

        files['picture'] = draw_stroke(recording, png)
    mean = float(force.mean())
    if as_json:
        peak = max((cycle.peak_friction for cycle in cycles), default=None)
        data = {'bag': bag, **files, 'mean_friction': mean, 'peak_friction': peak}
        output.print_json({**data, 'cycles': [cycle.to_dict() for cycle in cycles]})
        return
    if cycles:
        heads = ('>cycle', '>breakaway [s]', '>dwell [s]', '>slip [mm]', '>peak friction [N]')
        rows = [
            (
                str(number),
                f'{cycle.breakaway_time:.3f}',
                f'{cycle.dwell:.3f}',
                f'{cycle.slip * 1e3:.2f}',
                f'{cycle.peak_friction:.2f}',
            )
            for number, cycle in enumerate(cycles, start=1)
        ]
        output.print_table(heads, rows)
    else:
        output.console().print('no stick-slip cycle: the piston did not break away')
    output.console().print()
    output.print_values({'mean friction': f'{mean:.2f} N', **files})


@click.command(
    epilog=options.examples(
        'pneu-rig repair runs/2026-01-31_12-00-00_cylinder_2',
        'for bag in runs/*; do pneu-rig repair "$bag"; done',
    ),
)
@options.bag_argument
@options.output_options
def repair(bag: Path, as_json: bool, quiet: bool) -> None:
    """
    Repair a bag whose recorder was killed, or that is damaged.

    Normally less than the last half second before the kill is lost. The damaged file is kept
    beside the new one. A healthy bag is not changed.
    """
    from pneu_rig_ros.records import repair as repair_bag

    report = repair_bag(bag)
    if as_json:
        output.print_json(asdict(report))
    if as_json or quiet:
        return
    terminal = output.console()
    size = f'{report.messages} messages, {report.duration:.2f} s'
    if not report.repaired:
        terminal.print(f'{report.path} is healthy ({size}); nothing changed')
        return
    terminal.print(f'{report.path} is repaired: {size}')
    if not report.configuration_found:
        lost = report.configuration_lost
        reason = 'was lost with a damaged chunk' if lost else 'is not in the bag'
        terminal.print(f'the rig configuration {reason}; friction cannot be estimated')
    if count := report.damaged_chunks:
        terminal.print(f'{count} damaged {"chunk is" if count == 1 else "chunks are"} omitted')
    terminal.print(f'the damaged file is kept: {report.cut_file}', style='dim')


@click.command(
    'import',
    epilog=options.examples(
        'pneu-rig import daq.csv --map map.yaml --conditions cond.yaml --out runs/measured',
        'pneu-rig import other_bag --map topics.yaml --cylinder cylinder_2 --out runs/measured',
    )
    + '\b\nA mapping names the columns (or their numbers, from 1) and their units:\n'
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
    as_json: bool,
    quiet: bool,
) -> None:
    """
    Convert measured data (CSV, bags of other rigs) into a bag.

    FILE is a text table with any column names, units, separator and decimal sign; BAG has any
    topics and message types. Everything is converted to SI units and absolute pressures.
    """
    out = options.bag_path(out, 'measured')

    from pneu_rig_ros.records import conditions as known_conditions
    from pneu_rig_ros.records import read_recording
    from pneu_rig_ros.records.conversion import write_bag
    from pneu_rig_ros.records.recording import WHOLE

    read_conditions = known_conditions.read_conditions
    known = read_conditions(conditions) if conditions else {}
    configuration = options.load(cylinder, {}) if cylinder else None
    with options.directory(out.parent), output.stage_bar(quiet) as progress:
        progress('reading', 0.0)
        recording = read_recording(source, mapping, known.get('atmospheric_pressure'))
        writing, size = f'writing {recording.size} samples', recording.size
        write_bag(
            recording,
            out,
            known,
            configuration,
            lambda done: progress(writing, READING + (1.0 - READING) * done / size),
        )
    missing = max((stamps.size for stamps in recording.missing.values()), default=0)
    samples = recording.size - missing
    written = out / known_conditions.FILE_NAME
    values = read_conditions(written) if written.exists() else {}
    if as_json:
        output.print_json(
            {
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
        )
    if as_json or quiet:
        return
    texts = [f'{k} {v:g} {known_conditions.CONDITIONS[k].unit}' for k, v in values.items()]
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


@click.command(
    epilog=options.examples(
        'pneu-rig export runs/BAG --csv',
        'pneu-rig export runs/BAG --parquet --out stroke.parquet',
    ),
)
@options.bag_argument
@click.option('--csv', is_flag=True, help='write a CSV file')
@click.option('--parquet', is_flag=True, help='write a Parquet file')
@options.out_file(help='file to write; must not exist  [default: BAG.csv or BAG.parquet]')
@options.output_options
def export(
    bag: Path, csv: bool, parquet: bool, out: Path | None, as_json: bool, quiet: bool
) -> None:
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
    signals = conversion.read_signals(bag)
    write = conversion.write_csv if csv else conversion.write_parquet
    write(signals, file)
    columns = [column.title for column in signals.columns]
    samples = int(signals.columns[0].values.size)
    if as_json:
        output.print_json({'bag': bag, 'file': file, 'samples': samples, 'columns': columns})
    elif not quiet:
        output.print_values({'columns': ', '.join(columns), 'samples': samples, 'file': file})
