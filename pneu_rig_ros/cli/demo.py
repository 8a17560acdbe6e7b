"""`pneu-rig demo`: the rig live over ROS 2."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.cli import options, output

if TYPE_CHECKING:
    from pneu_rig_ros.demo import Value
    from pneu_rig_ros.rig import RigConfiguration


@click.command(
    short_help='The rig live over ROS 2: one stroke, recorded',
    epilog='\b\nExamples:\n'
    '  pneu-rig demo\n'
    '  pneu-rig demo --cylinder cylinder_1 --u 0.29 --duration 30\n'
    '  pneu-rig demo --supply-pressure 7e5 --out runs/six_bar\n'
    '\b\nWatch it from another terminal with the printed ROS_DOMAIN_ID, e.g.:\n'
    '  ros2 topic hz /joint_states\n',
)
@options.stroke_options
@click.option('--json', 'as_json', is_flag=True, help='print the summary as JSON')
@options.quiet_option
def demo(
    u: float,
    duration: float,
    out: Path | None,
    cylinder: str,
    as_json: bool,
    quiet: bool,
    **settings: Any,
) -> None:
    """
    Run the rig live over ROS 2: one stroke, recorded and summarised.

    Starts plant, valve_command, friction_estimator and recorder in processes of their own, holds
    the command u, and ends with a bag, a summary and a picture.
    """
    options.check_stroke(u, duration)
    configuration = options.load(cylinder, settings)
    _load_ros()
    path = options.bag_path(out, cylinder)
    try:
        with options.directory(path.parent):
            _record(path, configuration, cylinder, settings, u, duration, quiet)
    except KeyboardInterrupt:
        if (path / 'metadata.yaml').exists():
            output.console(stderr=True).print(f'recorded up to here: {path}')
        raise
    _show(path, as_json, quiet)


def _load_ros() -> None:
    """Import rclpy, which may start this process anew, before anything is done."""
    from pneu_rig_ros.demo import prepare_environment
    from pneu_rig_ros.errors import RigError

    prepare_environment()
    try:
        import pneu_rig_ros.nodes.startup  # noqa: F401
    except ImportError as error:
        raise RigError(
            f'ROS 2 is not to be found ({error}); source your ROS 2, install the package with '
            "its extra 'ros', or use: pneu-rig simulate"
        ) from error


def _record(
    path: Path,
    configuration: RigConfiguration,
    cylinder: str,
    settings: dict[str, Any],
    u: float,
    duration: float,
    quiet: bool,
) -> None:
    import os

    from pneu_rig_ros.demo import LiveRig
    from pneu_rig_ros.rig import Rig

    terminal = output.console(stderr=True, quiet=quiet)
    terminal.print(f'ROS_DOMAIN_ID={os.environ["ROS_DOMAIN_ID"]}', style='dim')
    with terminal.status('compiling the plant') as status:
        Rig(configuration).warm_up()  # the nodes do not wait for each other that long
        with LiveRig(path, _plant_parameters(cylinder, settings), status.update) as rig:
            title = f'{configuration.name} at u = {u:g} V'
            status.stop()
            with output.progress_bar(title, duration, quiet) as progress:
                rig.drive(u, duration, progress)
            status.start()


def _plant_parameters(cylinder: str, settings: dict[str, Any]) -> dict[str, Value]:
    """Return the plant's parameters; a file is named in full, as a node may run elsewhere."""
    file = Path(cylinder)
    name = str(file.resolve()) if file.exists() else cylinder
    given = {key: value for key, value in settings.items() if value is not None}
    return {'cylinder': name, **given}


def _show(path: Path, as_json: bool, quiet: bool) -> None:
    from pneu_rig_ros.analysis.summary import summarise
    from pneu_rig_ros.records import read_recording
    from pneu_rig_ros.report.figure import draw_stroke

    recording = read_recording(path)
    picture = draw_stroke(recording, path / 'stroke.png')
    if as_json or not quiet:
        files = {'bag': path, 'picture': picture}
        output.tell_summary(summarise(recording), files, as_json)
