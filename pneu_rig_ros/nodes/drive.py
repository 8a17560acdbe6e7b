"""A constant command for a while, as the simplest controller of the rig."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.signals import SignalHandlerOptions

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes import wiring
from pneu_rig_ros.nodes.pacing import Metronome
from pneu_rig_ros.records.cdr import pack_float64

PERIOD_NS = 20_000_000
"""Commands come at 50 Hz, often enough for any sensible `command_timeout`."""

DISCOVERY_TIMEOUT = 30.0

Progress = Callable[[float], None]
"""Told the time since the start [s]."""


def drive(
    u: float,
    duration: float,
    progress: Progress | None = None,
    subscribers: int = 2,
    namespace: str = '',
) -> None:
    """
    Hold the command u [V] for `duration` [s], then set it to 0, also when interrupted.

    :param progress: called with the elapsed time [s] at every command, and with 0 while the rig
        is looked for; what it raises ends the drive
    :param subscribers: of `u` to wait for first: valve command and recorder
    :param namespace: of the rig
    :raises RigError: when the rig is not found
    """
    with _node(namespace) as node:
        publisher = wiring.outlet(node, 'u')
        told = progress or (lambda _: None)
        _await(publisher, subscribers, told)
        try:
            _hold(publisher, u, duration, told)
        finally:
            publisher.publish(pack_float64(0.0))
            # Not sent is not said: let the middleware confirm the last command.
            publisher.wait_for_all_acked(rclpy.duration.Duration(seconds=1.0))


def _hold(publisher: Publisher, u: float, duration: float, progress: Progress) -> None:
    message = pack_float64(u)
    metronome = Metronome(PERIOD_NS)
    start = time.monotonic()
    while (elapsed := time.monotonic() - start) < duration:
        publisher.publish(message)
        progress(elapsed)
        metronome.wait()
    progress(duration)


def _await(publisher: Publisher, subscribers: int, progress: Progress) -> None:
    deadline = time.monotonic() + DISCOVERY_TIMEOUT
    pause = Metronome(PERIOD_NS)
    while publisher.get_subscription_count() < subscribers:
        if time.monotonic() > deadline:
            raise RigError(
                f'{publisher.topic_name}: {publisher.get_subscription_count()} of {subscribers} '
                f'subscribers after {DISCOVERY_TIMEOUT:g} s; start valve_command and recorder'
            )
        progress(0.0)
        pause.wait()


@contextmanager
def _node(namespace: str) -> Iterator[Node]:
    context = Context()
    options = SignalHandlerOptions.NO
    rclpy.init(context=context, signal_handler_options=options)
    node = Node('drive', namespace=namespace, context=context)
    try:
        yield node
    finally:
        node.destroy_node()
        context.try_shutdown()
