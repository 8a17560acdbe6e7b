"""`pneu-rig info`: what a bag holds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.cli import options, output

if TYPE_CHECKING:
    from pneu_rig_ros.records import Recording


@click.command(
    short_help='What a bag holds',
    epilog='\b\nExamples:\n'
    '  pneu-rig info runs/2026-01-31_12-00-00_cylinder_2\n'
    '  pneu-rig info runs/BAG --json | jq .lost\n',
)
@options.bag_argument
@click.option('--json', 'as_json', is_flag=True, help='print plain data for scripts')
def info(bag: Path, as_json: bool) -> None:
    """Tell what a bag holds: rig, topics, timing, losses, stick-slip cycles."""
    from pneu_rig_ros.analysis.summary import summarise
    from pneu_rig_ros.records import read_recording

    recording = read_recording(bag)
    summary = summarise(recording)
    if as_json:
        data = {'messages': dict(recording.counts), 'checksums': recording.protected}
        output.print_json({'bag': str(bag), **_origin(recording), **data, **summary.to_dict()})
        return
    output.print_summary(summary, {'bag': bag})
    origin = _origin(recording)
    text = f'pneu_rig_ros {origin["package_version"]}, revision {origin["git_revision"]}'
    whole, lacking = 'of every message', 'none: changed bits would go unnoticed'
    checked = whole if recording.protected else lacking
    output.print_values({'written by': text, 'checksums': checked})
    output.console().print()
    _print_topics(recording, summary.lost)


def _origin(recording: Recording) -> dict[str, Any]:
    keys = ('package_version', 'git_revision')
    return {key: recording.metadata.get(key, 'unknown') for key in keys}


def _print_topics(recording: Recording, lost: dict[str, int]) -> None:
    from rich import box
    from rich.table import Table

    from pneu_rig_ros.records.topics import TOPICS

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for name in ('topic', 'type'):
        table.add_column(name)
    for name in ('messages', 'lost'):
        table.add_column(name, justify='right')
    for topic, count in recording.counts.items():
        missing = str(lost[topic]) if topic in lost else output.NOT_KNOWN
        table.add_row(topic, TOPICS[topic].type, str(count), missing)
    output.console().print(table)
