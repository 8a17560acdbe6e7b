"""ROS inside another program: a context of its own, nodes and simple clients of a rig."""

import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

import rclpy
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes.rig_node import RigNode
from pneu_rig_ros.nodes.runner import Runner
from pneu_rig_ros.nodes.timing import PeriodicTimer
from pneu_rig_ros.nodes.topics import PolledSubscription, create_publisher
from pneu_rig_ros.records.cdr_encoding import pack_float64

Run = Callable[[Callable[[], bool]], None]
_Node = TypeVar('_Node', bound=RigNode)

DISCOVERY_TIMEOUT = 30.0
"""Longest time that nodes take to discover each other on a busy computer [s]."""

POLL_INTERVAL = 0.02
"""Time between two checks of an awaited condition [s]."""

COMMAND_PERIOD_NS = 20_000_000
"""Commands are published at 50 Hz, often enough for any sensible `command_timeout`."""

COMMAND_SUBSCRIBERS = 2
"""Of `u`, to wait for: valve command and recorder."""

RECORDED_ONLY = ('position', 'velocity')
"""Topics of the plant that only the recorder subscribes to."""

PLANT_SUBSCRIBERS = 2
"""
`wait_for_subscribers` of a plant that `await_first_sample` waits for.

Friction estimator and recorder subscribe to the other topics of the plant. `await_first_sample`
is the second subscriber of RECORDED_ONLY, so that the plant waits for two on every topic, and so
for both nodes.
"""


@contextmanager
def ros_context(namespace: str = '') -> Iterator[Context]:
    """
    Initialise ROS for the block, with its nodes in a namespace and without signal handlers.

    :raises RigError: when the namespace is not valid
    """
    if not re.fullmatch(r'(/?[A-Za-z_]\w*)*', namespace):
        raise RigError(f'namespace {namespace!r}: allowed are names such as left or lab/left')
    arguments = ['--ros-args', '-r', f'__ns:=/{namespace.strip("/")}'] if namespace else []
    context = Context()
    rclpy.init(args=arguments, context=context, signal_handler_options=SignalHandlerOptions.NO)
    try:
        yield context
    finally:
        context.try_shutdown()


@contextmanager
def embedded(
    factory: Callable[[Context], _Node], namespace: str = ''
) -> Iterator[tuple[_Node, Run]]:
    """
    Create a node inside another program; yield it and `Runner.run`, then close it.

    :raises RigError: when the namespace or a parameter of the node is not valid
    """
    with ros_context(namespace) as context:
        node = factory(context)
        runner = Runner([node])
        try:
            yield node, runner.run
        finally:
            runner.close()


@contextmanager
def _client(name: str, namespace: str = '') -> Iterator[Node]:
    """Yield a plain node that nothing executes."""
    with ros_context(namespace) as context:
        node = Node(name, context=context)
        try:
            yield node
        finally:
            node.destroy_node()


def await_first_sample(check: Callable[[], None]) -> None:
    """
    Return as soon as the plant has published a sample.

    :param check: called repeatedly; raises when waiting has become pointless
    :raises RigError: when there is no sample within :data:`DISCOVERY_TIMEOUT`
    """
    with _client('await_first_sample') as node:
        subscription, _ = [PolledSubscription(node, topic) for topic in RECORDED_ONLY]
        deadline = time.monotonic() + DISCOVERY_TIMEOUT
        while subscription.take() is None:
            check()
            if time.monotonic() > deadline:
                raise RigError(
                    f'no sample on {subscription.name} within {DISCOVERY_TIMEOUT:g} s: nodes '
                    'do not discover each other; is DDS blocked on the loopback interface?'
                )
            time.sleep(POLL_INTERVAL)


def hold_command(
    u: float,
    duration: float,
    progress: Callable[[float], None] = lambda _: None,
    namespace: str = '',
) -> None:
    """
    Hold the command u [V] for `duration` [s], then set it to 0, also when interrupted.

    :param progress: called with the elapsed time [s] at every command, and with 0 while waiting
        for subscribers; an exception that it raises ends the command
    :raises RigError: when the subscribers are not found, or the namespace is not valid
    """
    with _client('constant_command', namespace) as node:
        publisher = create_publisher(node, 'u')
        deadline = time.monotonic() + DISCOVERY_TIMEOUT
        while (present := publisher.get_subscription_count()) < COMMAND_SUBSCRIBERS:
            if time.monotonic() > deadline:
                raise RigError(
                    f'{publisher.topic_name}: {present} of {COMMAND_SUBSCRIBERS} subscribers '
                    f'after {DISCOVERY_TIMEOUT:g} s; start valve_command and recorder'
                )
            progress(0.0)
            time.sleep(POLL_INTERVAL)
        message = pack_float64(u)
        timer = PeriodicTimer(COMMAND_PERIOD_NS)
        start = time.monotonic()
        try:
            while (elapsed := time.monotonic() - start) < duration:
                publisher.publish(message)
                progress(elapsed)
                timer.wait()
            progress(duration)
        finally:
            publisher.publish(pack_float64(0.0))
            # The context must not end before the last command has been received.
            publisher.wait_for_all_acked(Duration(seconds=1.0))
