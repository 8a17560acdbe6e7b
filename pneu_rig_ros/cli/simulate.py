"""`pneu-rig simulate`: the rig offline."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from pneu_rig_ros.cli import options, output


@click.command(
    short_help='The same offline, without ROS, many times faster',
    epilog='\b\nExamples:\n'
    '  pneu-rig simulate\n'
    '  pneu-rig simulate --cylinder cylinder_3 --u 0.32 --duration 60 --out runs/c3\n'
    '  pneu-rig simulate --sensors ideal --friction lugre --png stroke.png\n'
    '  pneu-rig simulate --json | jq .cycle_count\n',
)
@options.stroke_options
@click.option('--png', type=click.Path(path_type=Path), metavar='FILE', help='draw the stroke')
@click.option('--json', 'as_json', is_flag=True, help='print the summary as JSON')
@options.quiet_option
def simulate(
    u: float,
    duration: float,
    out: Path | None,
    cylinder: str,
    png: Path | None,
    as_json: bool,
    quiet: bool,
    **settings: Any,
) -> None:
    """
    Run the rig offline: the same bag as live in lock step, many times faster.

    Needs no ROS. Time is simulated and starts at 0 s.
    """
    options.check_stroke(u, duration)
    configuration = options.load(cylinder, settings)
    picture = options.new_picture(png)
    path = options.bag_path(out, cylinder)

    from pneu_rig_ros.analysis.summary import summarise
    from pneu_rig_ros.records import read_recording
    from pneu_rig_ros.simulate import simulate as run

    title = f'{configuration.name} at u = {u:g} V'
    bar = output.progress_bar(title, duration, quiet)
    with options.directory(path.parent), bar as progress:
        run(configuration, u, duration, path, progress)
    recording = read_recording(path)
    files = {'bag': path}
    if picture:
        from pneu_rig_ros.report.figure import draw_stroke

        files['picture'] = draw_stroke(recording, picture)
    if as_json or not quiet:
        output.tell_summary(summarise(recording), files, as_json)
