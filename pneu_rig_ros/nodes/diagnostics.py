"""`/diagnostics` at 1 Hz: the status of a node, and the counters and checks behind it."""

import os
import socket
import time
from collections.abc import Mapping
from typing import NamedTuple

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

PROCESS_KEY = 'process'
"""Key on `/diagnostics` under which a node states its process."""


def process_id() -> str:
    """Return a name that no other process has: its number and host."""
    return f'{os.getpid()}@{socket.gethostname()}'


class NodeStatus(NamedTuple):
    """
    Status of a node.

    :param state: what the node does, shown when there is no problem
    :param warnings: problems, None for those that are absent
    :param errors: worse problems, None for those that are absent
    """

    state: str
    values: Mapping[str, object]
    warnings: tuple[str | None, ...] = ()
    errors: tuple[str | None, ...] = ()

    @property
    def level(self) -> bytes:
        """The level of the worst problem."""
        warning = DiagnosticStatus.WARN if any(self.warnings) else DiagnosticStatus.OK
        return bytes(DiagnosticStatus.ERROR if any(self.errors) else warning)

    @property
    def message(self) -> str:
        """All problems, errors first; the state if there is none."""
        return '; '.join(filter(None, (*self.errors, *self.warnings))) or self.state

    def to_message(self, node: Node) -> DiagnosticArray:
        """Return this status of a node as it is published."""
        values = {**self.values, PROCESS_KEY: process_id()}
        status = DiagnosticStatus(
            level=self.level,
            name=node.get_fully_qualified_name(),
            # the rig, one for all nodes in a namespace: pneu_rig/left
            hardware_id=f'pneu_rig{node.get_namespace().rstrip("/")}',
            message=self.message,
            values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = node.get_clock().now().to_msg()
        return array


class RateCounter:
    """Counts events: increase `count`, the number since the start."""

    def __init__(self) -> None:
        self.count = 0
        self.per_second = 0.0
        """Mean rate between the last two updates [Hz]."""
        self._last_count = 0
        self._last_ns = time.monotonic_ns()

    def update(self) -> float:
        """Return the mean rate since the last update [Hz]."""
        now = time.monotonic_ns()
        elapsed = (now - self._last_ns) * 1e-9
        self.per_second = (self.count - self._last_count) / elapsed if elapsed > 0 else 0.0
        self._last_ns, self._last_count = now, self.count
        return self.per_second
