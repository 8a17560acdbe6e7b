"""ROS inside another program: a context of its own, and waiting for the first sample."""

import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes.topics import PolledSubscription

DISCOVERY_TIMEOUT = 30.0
"""Longest time that nodes take to discover each other on a busy computer [s]."""

POLL_INTERVAL = 0.02
"""Time between two looks for what is awaited [s]."""

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
    Initialise ROS for the block, without signal handlers.

    :param namespace: of all nodes in the context
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


def await_first_sample(check: Callable[[], None], timeout: float = DISCOVERY_TIMEOUT) -> None:
    """
    Return as soon as the plant has published a sample.

    :param check: called repeatedly; raises when waiting has become pointless
    :param timeout: longest wait [s]
    :raises RigError: when there is no sample within the timeout
    """
    with ros_context() as context:
        node = Node('await_first_sample', context=context)
        subscription, _ = [PolledSubscription(node, topic) for topic in RECORDED_ONLY]
        deadline = time.monotonic() + timeout
        try:
            while subscription.take() is None:
                check()
                if time.monotonic() > deadline:
                    raise RigError(
                        f'no sample on {subscription.name} within {timeout:g} s: nodes do not '
                        'discover each other; is DDS blocked on the loopback interface?'
                    )
                time.sleep(POLL_INTERVAL)
        finally:
            node.destroy_node()
