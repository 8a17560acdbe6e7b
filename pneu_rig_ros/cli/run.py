"""Commands that run a rig or play a bag: demo, simulate, live and replay."""

from __future__ import annotations

import contextlib
import os
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.cli import options, output
from pneu_rig_ros.errors import RigError

if TYPE_CHECKING:
    from pneu_rig_ros.demo import NodeProcess


@options.command(
    'pneu-rig demo',
    'pneu-rig demo --cylinder cylinder_1 --u 0.29 --duration 30',
    'pneu-rig demo --supply-pressure 7e5 --out runs/six_bar_gauge',
    after='Watch it from another terminal with the printed ROS_DOMAIN_ID, e.g.:\n'
    '  ros2 topic hz /joint_states\n',
)
@options.stroke_options
@options.output_options
def demo(
    u: float,
    duration: float,
    out: Path | None,
    cylinder: str,
    **settings: Any,
) -> None:
    """
    Run the rig live over ROS 2: one stroke, recorded.

    Starts plant, valve_command, friction_estimator and recorder in processes of their own and
    holds the command u. The result is a bag, a summary and a picture.
    """
    from pneu_rig_ros.demo import absolute, drive, prepare_environment, recorded_rig

    configuration = options.load(cylinder, settings)
    prepare_environment()
    options.load_ros()
    path = options.bag_path(out, cylinder)
    parameters = {'cylinder': absolute(cylinder)}
    parameters |= {name: value for name, value in settings.items() if value is not None}
    terminal = output.console(stderr=True, quiet=output.chosen('--quiet'))
    terminal.print(f'ROS_DOMAIN_ID={os.environ["ROS_DOMAIN_ID"]}', style='dim')
    try:
        with (
            options.directory(path.parent),
            terminal.status('compiling the plant') as status,
            recorded_rig(path, configuration, parameters, status.update) as nodes,
        ):
            status.stop()
            title = f'{configuration.name} at u = {u:g} V'
            with output.progress_bar(title, duration, 's') as progress:
                drive(nodes, u, duration, progress)
            status.start()
    except KeyboardInterrupt:
        if (path / 'metadata.yaml').exists():
            output.console(stderr=True).print(f'recorded up to here: {path}')
        raise
    _summarise(path, path / 'stroke.png')


@options.command(
    'pneu-rig simulate',
    'pneu-rig simulate --cylinder cylinder_3 --u 0.32 --duration 60 --out runs/c3',
    'pneu-rig simulate --sensors ideal --friction lugre --png stroke.png',
    'pneu-rig simulate --json | jq .cycle_count',
)
@options.stroke_options
@options.png_option
@options.output_options
def simulate(
    u: float,
    duration: float,
    out: Path | None,
    cylinder: str,
    png: Path | None,
    **settings: Any,
) -> None:
    """
    Run the rig offline, without ROS, many times faster.

    The bag is that of the live rig in lock step: time is simulated and starts at 0 s.
    """
    configuration = options.load(cylinder, settings)
    path = options.bag_path(out, cylinder)

    from pneu_rig_ros.simulate import simulate as run

    title = f'{configuration.name} at u = {u:g} V'
    bar = output.progress_bar(title, duration, 's')
    with options.directory(path.parent), bar as progress:
        run(configuration, u, duration, path, progress)
    _summarise(path, png)


def _summarise(bag: Path, picture: Path | None) -> None:
    """Draw the stroke if asked for, and print the summary of a new bag."""
    from pneu_rig_ros.analysis.summary import summarise
    from pneu_rig_ros.records import read_recording

    recording = read_recording(bag)
    files = {'bag': bag}
    if picture:
        from pneu_rig_ros.report.figure import draw_stroke

        files['picture'] = draw_stroke(recording, picture)
    summary = summarise(recording)
    if output.as_text({**files, **summary.to_dict()}):
        output.print_summary(summary, files)


@options.command(
    'pneu-rig live                          a rig that runs already, e.g. by rig.launch.py',
    'pneu-rig live --start cylinder_1       starts and stops a rig too',
    'pneu-rig live --namespace left --port 8863',
)
@options.number_option(
    '--port', options.Whole(0, 65535), 8862, 'TCP port of the page; 0: any free one'
)
@options.namespace_option
@click.option('--start', metavar='NAME|FILE', help='start a rig with this cylinder too')
@click.option('--browse', is_flag=True, help='open the page in the browser')
def live(port: int, namespace: str, start: str | None, browse: bool) -> None:
    """
    Show and command a running rig in the browser.

    Serves a page to browsers on this computer. The page publishes u only after its slider was
    moved, so that a controller can be watched too. When the page is closed, u returns to 0. A
    node of --start that is killed is restarted. Stop with Ctrl-C.
    """
    from pneu_rig_ros import demo

    if start and namespace:
        raise RigError('--start is for a rig without --namespace')
    if start:
        options.load(start, {})
        demo.prepare_environment()
    options.load_ros()
    terminal = output.console(stderr=True)
    with demo.held_signals() as received, contextlib.ExitStack() as rig:
        nodes: list[NodeProcess] = []
        if start:
            nodes = rig.enter_context(demo.restartable_rig(start))
            terminal.print(f'ROS_DOMAIN_ID={os.environ["ROS_DOMAIN_ID"]}', style='dim')
        _serve(port, namespace, browse, nodes, received)


def _serve(
    port: int, namespace: str, browse: bool, nodes: list[NodeProcess], received: list[int]
) -> None:
    from pneu_rig_ros.nodes.embedding import embedded
    from pneu_rig_ros.nodes.live import LiveNode
    from pneu_rig_ros.web.server import serve

    def keep_running() -> bool:
        for node in nodes:
            if node.revive():
                output.console(stderr=True).print(f'{node.name} was killed and is restarted')
        return not received

    with embedded(LiveNode, namespace) as (node, run), serve(node, port) as address:
        output.console().print(f'{address} (stop with Ctrl-C)')
        if browse:
            click.launch(address)
        run(keep_running)


@options.command(
    'pneu-rig replay runs/BAG                     at the speed of the recording',
    'pneu-rig replay runs/BAG --rate 5 --clock    five times as fast, with /clock',
    'pneu-rig replay runs/BAG --exclude u         for a controller that publishes u itself',
    'pneu-rig replay runs/BAG --topic friction --topic joint_states',
)
@options.bag_argument
@options.number_option(
    '--rate', options.Between(0.01, 100.0), 1.0, 'playback speed relative to the recording'
)
@click.option('--repeat', is_flag=True, help='play in a loop until interrupted')
@click.option('--clock', is_flag=True, help='publish /clock, from the log times')
@click.option('--topic', multiple=True, metavar='TOPIC', help='play only this topic; repeatable')
@click.option('--exclude', multiple=True, metavar='TOPIC', help='omit this topic; repeatable')
@options.number_option(
    '--delay',
    options.Between(0.0, 3600.0),
    1.0,
    'time for discovery before the start [s]',
    'SECOND',
)
@options.number_option(
    '--subscribers', options.Whole(0, 100), 0, 'subscribers of each topic to wait for'
)
@options.namespace_option
@options.output_options
def replay(
    bag: Path,
    topic: tuple[str, ...],
    exclude: tuple[str, ...],
    subscribers: int,
    namespace: str,
    **settings: Any,
) -> None:
    """
    Play a bag back over ROS 2, for nodes driven by recorded data.

    The messages are unchanged. Topics that nodes compute from others (friction, predictions,
    diagnostics) are omitted unless named with --topic. `ros2 bag play BAG` plays all topics.
    """
    options.load_ros()

    from pneu_rig_ros.demo import held_signals
    from pneu_rig_ros.nodes.embedding import embedded
    from pneu_rig_ros.nodes.replay import ReplayNode

    parameters = {
        'bag': str(bag),
        'topics': ','.join(topic),
        'exclude': ','.join(exclude),
        'wait_for_subscribers': subscribers,
        **settings,
    }
    with (
        held_signals() as received,
        embedded(partial(ReplayNode, overrides=parameters), namespace) as (node, run),
    ):
        title = f'{bag.name} at {settings["rate"]:g}x'
        with output.progress_bar(title, node.duration, 's') as progress:

            def unfinished() -> bool:
                progress(node.elapsed)
                return not (received or node.done)

            run(unfinished)
        if received:
            raise KeyboardInterrupt
        count = node.rate.count
        if output.as_text({'elapsed': node.elapsed, 'messages': count}):
            output.print_values({'played': f'{node.elapsed:.2f} s', 'messages': count})
