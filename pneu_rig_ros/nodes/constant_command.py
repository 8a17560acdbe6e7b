"""The simplest controller of the rig: a constant command for a given time."""

import time
from collections.abc import Callable

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes.loop_timer import PeriodicTimer
from pneu_rig_ros.nodes.startup import DISCOVERY_TIMEOUT, POLL_INTERVAL, ros_context
from pneu_rig_ros.nodes.topics import create_publisher
from pneu_rig_ros.records.cdr import pack_float64

PERIOD_NS = 20_000_000
"""Commands are published at 50 Hz, often enough for any sensible `command_timeout`."""

Progress = Callable[[float], None]
"""Receives the time since the start [s]."""


def hold_command(
    u: float,
    duration: float,
    progress: Progress = lambda _: None,
    subscribers: int = 2,
    namespace: str = '',
) -> None:
    """
    Hold the command u [V] for `duration` [s], then set it to 0, also when interrupted.

    :param progress: called with the elapsed time [s] at every command, and with 0 while waiting
        for subscribers; an exception that it raises ends the command
    :param subscribers: number of subscribers of `u` to wait for: valve command and recorder
    :param namespace: of the rig
    :raises RigError: when the subscribers are not found, or the namespace is not valid
    """
    with ros_context(namespace) as context:
        node = Node('constant_command', context=context)
        try:
            publisher = create_publisher(node, 'u')
            _await_subscribers(publisher, subscribers, progress)
            try:
                _publish_repeatedly(publisher, u, duration, progress)
            finally:
                publisher.publish(pack_float64(0.0))
                # The context must not end before the last command has been received.
                publisher.wait_for_all_acked(Duration(seconds=1.0))
        finally:
            node.destroy_node()


def _publish_repeatedly(
    publisher: Publisher, u: float, duration: float, progress: Progress
) -> None:
    message = pack_float64(u)
    timer = PeriodicTimer(PERIOD_NS)
    start = time.monotonic()
    while (elapsed := time.monotonic() - start) < duration:
        publisher.publish(message)
        progress(elapsed)
        timer.wait()
    progress(duration)


def _await_subscribers(publisher: Publisher, subscribers: int, progress: Progress) -> None:
    deadline = time.monotonic() + DISCOVERY_TIMEOUT
    while publisher.get_subscription_count() < subscribers:
        if time.monotonic() > deadline:
            raise RigError(
                f'{publisher.topic_name}: {publisher.get_subscription_count()} of {subscribers} '
                f'subscribers after {DISCOVERY_TIMEOUT:g} s; start valve_command and recorder'
            )
        progress(0.0)
        time.sleep(POLL_INTERVAL)
