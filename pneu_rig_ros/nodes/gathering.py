"""Waits until a rig whose nodes wait for each other has begun."""

import time
from collections.abc import Callable

import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes.drive import DISCOVERY_TIMEOUT, PERIOD_NS
from pneu_rig_ros.nodes.pacing import Metronome
from pneu_rig_ros.nodes.wiring import Inlet

RECORDED_ONLY = ('position', 'velocity')
"""Topics of the plant that only the recorder subscribes to."""

PLANT_SUBSCRIBERS = 2
"""
For `wait_for_subscribers` of a plant that `await_first_sample` is called for.

Friction estimator and recorder subscribe to the other topics of the plant. A second subscriber of
RECORDED_ONLY, here, lets the plant wait for two on each topic, and so for both of them.
"""


def await_first_sample(
    still_possible: Callable[[], None], timeout: float = DISCOVERY_TIMEOUT
) -> None:
    """
    Return as soon as the plant has published a sample.

    :param still_possible: called all the while; raises when waiting has become pointless
    :param timeout: longest wait [s]
    :raises RigError: when the time is up
    """
    context = Context()
    rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    node = Node('gathering', context=context)
    try:
        inlets = [Inlet(node, topic) for topic in RECORDED_ONLY]
        _await(inlets[0], still_possible, timeout)
    finally:
        node.destroy_node()
        context.try_shutdown()


def _await(inlet: Inlet, still_possible: Callable[[], None], timeout: float) -> None:
    deadline = time.monotonic() + timeout
    pause = Metronome(PERIOD_NS)
    while inlet.take() is None:
        still_possible()
        if time.monotonic() > deadline:
            raise RigError(
                f'no sample on {inlet.name} within {timeout:g} s: the nodes do not find each '
                'other; is DDS kept from the loopback interface?'
            )
        pause.wait()
