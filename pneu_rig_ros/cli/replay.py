"""`pneu-rig replay`: a bag over ROS 2 again."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import click

from pneu_rig_ros.cli import options, output


@click.command(
    short_help='Publish a bag again, for nodes driven by recorded data',
    epilog='\b\nExamples:\n'
    '  pneu-rig replay runs/BAG                     in the time in which it was recorded\n'
    '  pneu-rig replay runs/BAG --rate 5 --clock    five times as fast, with /clock\n'
    '  pneu-rig replay runs/BAG --exclude u         for a controller that publishes u itself\n'
    '  pneu-rig replay runs/BAG --topic friction --topic joint_states\n',
)
@options.bag_argument
@click.option(
    '--rate', type=options.Between(0.01, 100.0), default=1.0, show_default=True, metavar='NUMBER',
    help='times as fast as recorded',
)  # fmt: skip
@click.option('--repeat', is_flag=True, help='begin anew at the end, until interrupted')
@click.option('--clock', is_flag=True, help='publish /clock, from the log times')
@click.option('--topic', multiple=True, metavar='TOPIC', help='play only this; repeatable')
@click.option('--exclude', multiple=True, metavar='TOPIC', help='leave this out; repeatable')
@click.option(
    '--delay',
    type=options.Between(0.0, 3600.0),
    default=1.0,
    show_default=True,
    metavar='SECOND',
    help='time to find subscribers before the start',
)
@click.option(
    '--subscribers',
    type=options.Whole(0, 100),
    metavar='INTEGER',
    default=0,
    show_default=True,
    help='wait until each topic played has so many',
)
@click.option('--namespace', default='', metavar='NAME', help='of the topics')
@click.option('--json', 'as_json', is_flag=True, help='print the summary as JSON')
@options.quiet_option
def replay(
    bag: Path,
    rate: float,
    repeat: bool,
    clock: bool,
    topic: tuple[str, ...],
    exclude: tuple[str, ...],
    delay: float,
    subscribers: int,
    namespace: str,
    as_json: bool,
    quiet: bool,
) -> None:
    """
    Publish the messages of BAG again, unchanged and in the pace in which they were recorded.

    What nodes compute from the others (friction, predictions, diagnostics) is left out, unless
    named with --topic. `ros2 bag play BAG` does the same with everything.
    """
    from pneu_rig_ros.nodes.replay import ReplayNode
    from pneu_rig_ros.nodes.runner import embedded

    parameters = {
        'bag': str(bag),
        'rate': rate,
        'repeat': repeat,
        'clock': clock,
        'topics': ','.join(topic),
        'exclude': ','.join(exclude),
        'delay': delay,
        'wait_for_subscribers': subscribers,
    }
    factory = partial(ReplayNode, overrides=parameters)
    with embedded(factory, namespace) as (node, run):
        with output.progress_bar(f'{bag.name} at {rate:g}x', node.duration, quiet) as progress:

            def unfinished() -> bool:
                progress(node.elapsed)
                return not node.done

            run(unfinished)
        if as_json:
            output.print_json({'elapsed': node.elapsed, 'messages': node.published})
        elif not quiet:
            rows = {'played': f'{node.elapsed:.2f} s', 'messages': str(node.published)}
            output.print_values(rows)
