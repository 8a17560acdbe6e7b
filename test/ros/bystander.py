"""A node beside the rig, and loops that end when something has happened."""

import time
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from pneu_rig_ros.nodes.runner import Runner
from pneu_rig_ros.nodes.topics import PolledSubscription, create_publisher

from .domain import own_domain

DOMAIN = own_domain()
PATIENCE = 30.0
PAUSE = 1e-3
"""Between two questions, so that what is waited for has the processor [s]."""


class Bystander(Node):
    """A node that is not one of the rig's: sends commands, listens, calls services."""

    def __init__(self, context: Context, namespace: str = '') -> None:
        super().__init__('bystander', context=context, namespace=namespace)

    def hear(self, topic: str) -> PolledSubscription:
        return PolledSubscription(self, topic)

    def speak(self, topic: str, subscribers: int = 1) -> Callable[[bytes], None]:
        publisher = create_publisher(self, topic)
        until(lambda: publisher.get_subscription_count() >= subscribers)
        return publisher.publish

    def call(self, runner: Runner | None, kind: Any, name: str, **request: object) -> Any:
        """Call a service of a node that the runner runs, or that runs by itself."""
        client = self.create_client(kind, name)
        until(client.service_is_ready)
        future = client.call_async(kind.Request(**request))
        executor = SingleThreadedExecutor(context=self.context)
        executor.add_node(self)

        def answered() -> bool:
            if runner:
                runner.spin_once()
            executor.spin_once(timeout_sec=0.01)
            return future.done()

        until(answered)
        executor.shutdown()
        return future.result()


def until(condition: Callable[[], object]) -> None:
    """Ask again and again, until the condition holds; fail when it takes too long."""
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline, f'not within {PATIENCE} s'
        time.sleep(PAUSE)


def gather(
    runner: Runner, subscriptions: Sequence[PolledSubscription], count: int
) -> list[list[bytes]]:
    """Run until `count` messages came from every subscription; return them."""
    heard: list[list[bytes]] = [[] for _ in subscriptions]

    def enough() -> bool:
        for messages, subscription in zip(heard, subscriptions, strict=True):
            messages.extend(subscription.take_all())
        return all(len(messages) >= count for messages in heard)

    deadline = time.monotonic() + PATIENCE
    runner.run(lambda: not enough() and time.monotonic() < deadline)
    assert enough(), f'{[len(messages) for messages in heard]} of {count} messages'
    return [messages[:count] for messages in heard]
