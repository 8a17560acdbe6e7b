"""Contexts of ROS, apart from all others."""

from collections.abc import Callable, Iterator

import pytest
import rclpy
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions

from pneu_rig_ros.nodes.rig_node import RigNode
from pneu_rig_ros.nodes.runner import Runner

from .bystander import DOMAIN, Bystander


@pytest.fixture(autouse=True)
def _apart(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    monkeypatch.setenv('ROS_DOMAIN_ID', str(DOMAIN))


@pytest.fixture
def new_context() -> Iterator[Callable[..., Context]]:
    """Make contexts, with ROS arguments such as remaps, that end with the test."""
    contexts = []

    def make(*arguments: str) -> Context:
        context = Context()
        args = ['--ros-args', *arguments] if arguments else []
        options = SignalHandlerOptions.NO
        rclpy.init(args=args, context=context, domain_id=DOMAIN, signal_handler_options=options)
        contexts.append(context)
        return context

    yield make
    for context in contexts:
        context.try_shutdown()


@pytest.fixture
def context(new_context: Callable[..., Context]) -> Context:
    """Return the one context of a test."""
    return new_context()


@pytest.fixture
def loop_of(new_context: Callable[..., Context]) -> Iterator[Callable[..., Runner]]:
    """Put nodes into loops, which end before the contexts of the test do."""
    runners = []

    def make(*nodes: RigNode) -> Runner:
        runners.append(Runner(nodes))
        return runners[-1]

    yield make
    for runner in runners:
        runner.close()


@pytest.fixture
def bystander(context: Context) -> Iterator[Bystander]:
    """Return a node that watches and drives the rig."""
    node = Bystander(context)
    yield node
    node.destroy_node()
