"""Commands on bags: info, view, friction, repair and compare."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pneu_rig_ros.cli import options, output
from pneu_rig_ros.errors import RigError

if TYPE_CHECKING:
    from pneu_rig_ros.analysis.comparison import Comparison
    from pneu_rig_ros.analysis.motion import Cycle


@options.command(
    'pneu-rig info runs/2026-01-31_12-00-00_cylinder_2',
    'pneu-rig info runs/BAG --json | jq .lost',
)
@options.bag_argument
@options.json_option
def info(bag: Path) -> None:
    """Show what a bag contains: rig, topics, timing, cycles."""
    from pneu_rig_ros.analysis.summary import summarise
    from pneu_rig_ros.records import read_recording
    from pneu_rig_ros.records.topics import TOPICS

    recording = read_recording(bag)
    summary = summarise(recording)
    version = recording.metadata.get('package_version', 'unknown')
    revision = recording.metadata.get('git_revision', 'unknown')
    origin = {'bag': bag, 'package_version': version, 'git_revision': revision}
    data = {'messages': dict(recording.counts), 'checksums': recording.protected}
    if not output.as_text({**origin, **data, **summary.to_dict()}):
        return
    output.print_summary(summary, {'bag': bag})
    checksums = 'of every message' if recording.protected else 'none: damage would go unnoticed'
    written_by = f'pneu_rig_ros {version}, revision {revision}'
    output.print_values({'written by': written_by, 'checksums': checksums})
    output.console().print()
    rows = [
        (topic, TOPICS[topic].type, str(count), str(summary.lost.get(topic, output.UNKNOWN)))
        for topic, count in recording.counts.items()
    ]
    output.print_table(('topic', 'type', '>messages', '>lost'), rows)


@options.command(
    'pneu-rig view runs/BAG                       writes BAG.html beside the bag',
    'pneu-rig view runs/BAG --out stroke.html',
    'pneu-rig view runs/BAG --from 12 --to 14.5   every sample of a part of a long bag',
)
@options.bag_argument
@options.out_file(help='page to write; must not exist  [default: BAG.html]')
@options.seconds_option('--from', 'start', help='start of the part to show')
@options.seconds_option('--to', 'stop', help='end of the part to show')
@options.quiet_option
def view(bag: Path, out: Path | None, start: float | None, stop: float | None) -> None:
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
    if not output.chosen('--quiet'):
        output.print_values({'page': page})


@options.command(
    'pneu-rig friction runs/BAG',
    'pneu-rig friction runs/BAG --csv friction.csv --png stroke.png',
    'pneu-rig friction runs/BAG --json | jq ".cycles[0].peak_friction"',
)
@options.bag_argument
@click.option('--csv', type=options.NewFile(), help='write the signals as CSV')
@options.png_option
@options.json_option
def friction(bag: Path, csv: Path | None, png: Path | None) -> None:
    """
    Estimate the friction force of a bag, offline.

    Uses Eq. 2 with the zero-phase 32 Hz filter of the paper, and prints the stick-slip cycles. The
    force is that of cylinder and guide together.
    """
    from pneu_rig_ros.analysis.friction import friction_of
    from pneu_rig_ros.analysis.motion import cycles_of
    from pneu_rig_ros.records import read_recording
    from pneu_rig_ros.records.conversion import columns_of, write_csv

    recording = read_recording(bag)
    force = friction_of(recording)
    cycles = cycles_of(recording, force)
    files: dict[str, Path] = {}
    if csv:
        derived = recording.with_signals(velocity=recording.velocity, friction=force)
        names = ('position', 'velocity', 'pressure_1', 'pressure_2', 'friction')
        files['csv'] = write_csv(columns_of(derived, names), csv)
    if png:
        from pneu_rig_ros.report.figure import draw_stroke

        files['picture'] = draw_stroke(recording, png)
    mean = float(force.mean())
    peak = max((cycle.peak_friction for cycle in cycles), default=None)
    data = {'bag': bag, **files, 'mean_friction': mean, 'peak_friction': peak}
    if output.as_text({**data, 'cycles': [cycle.to_dict() for cycle in cycles]}):
        _print_cycles(cycles)
        output.console().print()
        output.print_values({'mean friction': f'{mean:.2f} N', **files})


def _print_cycles(cycles: Sequence[Cycle]) -> None:
    if not cycles:
        output.console().print('no stick-slip cycle: the piston did not break away')
        return
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


@options.command(
    'pneu-rig repair runs/2026-01-31_12-00-00_cylinder_2',
    'for bag in runs/*/; do pneu-rig repair "$bag"; done',
)
@options.bag_argument
@options.output_options
def repair(bag: Path) -> None:
    """
    Repair a bag whose recorder was killed, or that is damaged.

    Normally less than the last half second before the kill is lost. The damaged file is kept
    beside the new one. A healthy bag is not changed.
    """
    from pneu_rig_ros.records import repair as repair_bag

    report = repair_bag(bag)
    if not output.as_text(asdict(report)):
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


@options.command(
    'pneu-rig compare runs/measured --model cylinder_2',
    'pneu-rig compare runs/measured --model improved.yaml --out comparison.html',
    'pneu-rig compare runs/monday --model runs/tuesday --json | jq .signals.position',
)
@click.argument('measured', type=options.PATH)
@click.option(
    '--model',
    required=True,
    metavar='NAME|FILE|BAG',
    help='a cylinder, a YAML file of your own, or another bag',
)
@options.seconds_option(
    '--shift', help='delay of the second bag [s]  [default: aligned by the onset of the command]'
)
@options.out_file(help='write an HTML page')
@options.output_options
def compare(measured: Path, model: str, shift: float | None, out: Path | None) -> None:
    """
    Compare a measured bag with a model or another bag.

    The model starts at the state where the bag starts and gets its conditions and recorded
    voltages; two bags are aligned by the onset of the command. Prints the error of each signal,
    in its unit and in multiples of the sensor noise, and the stick-slip cycles of both.
    """
    from pneu_rig_ros.analysis.comparison import compare_with_bag, compare_with_model
    from pneu_rig_ros.records import is_bag

    if is_bag(Path(model)):
        comparison = compare_with_bag(measured, model, shift)
    elif shift is not None:
        raise RigError('--shift is for two bags; a model starts with the bag')
    else:
        comparison = compare_with_model(measured, options.load(model, {}), model)
    files = {'page': out} if out else {}
    if out:
        from pneu_rig_ros.report import comparison_page as page

        with output.progress_bar('figures', page.FIGURES) as progress:
            page.write_page(out, comparison, progress)
    if output.as_text({**comparison.to_dict(), **files}):
        _print_comparison(comparison, files)


def _print_comparison(comparison: Comparison, files: dict[str, Path]) -> None:
    from pneu_rig_ros.report import comparison_page as page

    output.print_table(page.SIGNAL_HEADS, page.signal_rows(comparison))
    output.console().print()
    output.print_table(('', '>measured', f'>{comparison.second}'), page.event_rows(comparison))
    output.console().print()
    note = page.ratio_note(comparison)
    output.print_values(
        {
            'measured': comparison.measured.recording.name,
            comparison.second: comparison.simulated.recording.name,
            'conditions': ',\n'.join(page.condition_texts(comparison)) or output.UNKNOWN,
            **({'RMSE / noise': note} if note else {}),
            **({'shifted by': f'{-comparison.shift:.3f} s'} if comparison.shift else {}),
            **files,
        }
    )
