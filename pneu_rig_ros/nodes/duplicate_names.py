"""
Detection of two nodes of one name, i.e. of two rigs in one namespace, whose messages would mix.

Each node states its name and process on `/diagnostics` once a second, so that a node that
receives its own name from another process has a duplicate. A node that starts beside a duplicate
refuses to run. A node that died stays in the ROS graph for a while but publishes nothing, so that
its successor may start. On a busy computer discovery takes a while; a lock on the name shows
immediately that a duplicate runs on the same computer.
"""

import errno
import hashlib
import math
import socket
import sys
import time
from collections.abc import Callable, Iterable
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.serialization import deserialize_message

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes.diagnostics import PROCESS_KEY, process_id
from pneu_rig_ros.nodes.topics import PolledSubscription
from pneu_rig_ros.records.topics import DIAGNOSTICS

TIMEOUT, TIMEOUT_IN_GRAPH, TIMEOUT_ON_HOST = 0.5, 2.0, 20.0
"""
Time to wait for a duplicate at the start [s]: if there is no sign of one, if the graph has its
name, and if it runs on this computer.
"""

VALIDITY = 5.0
"""A duplicate that has been silent for longer no longer counts [s]."""

LOCK_PREFIX = '\0pneu_rig_ros/'


class DuplicateNameGuard:
    """
    Watches for other processes that run a node of the same name.

    :param node: listens to the diagnostics
    :param names: full names of the nodes of this process that must be unique
    """

    def __init__(self, node: Node, names: Iterable[str]) -> None:
        self._node = node
        self._last_seen = dict.fromkeys(names, -math.inf)
        self._held: dict[str, socket.socket] = {}
        self._diagnostics = PolledSubscription(node, DIAGNOSTICS)

    def update(self) -> list[str]:
        """Take the waiting diagnostics; return the names that have a duplicate."""
        now = time.monotonic()
        for cdr in self._diagnostics.take_all():
            message: Any = deserialize_message(cdr, DiagnosticArray)
            for status in message.status:
                process = {item.key: item.value for item in status.values}.get(PROCESS_KEY)
                if status.name in self._last_seen and process not in (None, process_id()):
                    self._last_seen[status.name] = now
        return [name for name, seen in self._last_seen.items() if now - seen < VALIDITY]

    def check(self, keep_waiting: Callable[[], bool]) -> None:
        """
        Return when no node has a duplicate that was started earlier.

        :param keep_waiting: ends the check early when it returns False
        :raises RigError: when a node has a duplicate
        """
        start = time.monotonic()
        while keep_waiting() and time.monotonic() - start < self._timeout():
            if found := self.update():
                raise RigError(
                    f'another {found[0]} is running: give this rig a namespace '
                    '(-r __ns:=/left) or another ROS_DOMAIN_ID'
                )
            time.sleep(0.02)

    def _timeout(self) -> float:
        """Return how long to wait [s]; holds all names that are free on this computer."""
        domain = self._node.context.get_domain_id()
        for name in self._last_seen.keys() - self._held.keys():
            if holder := hold_name(f'{domain}:{name}'):
                self._held[name] = holder
        if len(self._held) < len(self._last_seen):
            return TIMEOUT_ON_HOST
        in_graph = self._node.get_node_names_and_namespaces()
        full_names = [f'{namespace.rstrip("/")}/{name}' for name, namespace in in_graph]
        twice = any(full_names.count(name) > 1 for name in self._last_seen)
        return TIMEOUT_IN_GRAPH if twice else TIMEOUT

    def close(self) -> None:
        """Let others hold the names."""
        for holder in self._held.values():
            holder.close()


def hold_name(name: str) -> socket.socket | None:
    """
    Return what holds a name on this computer until it is closed; None if another one holds it.

    The name is the address of a socket in Linux's abstract namespace (unix(7)): no file is left
    behind, the kernel releases it however the process ends, and containers with a network of their
    own, which DDS does not reach either, do not share it. Outside Linux any name counts as free.
    """
    if sys.platform != 'linux':
        return socket.socket()
    holder = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    try:
        holder.bind(LOCK_PREFIX + hashlib.sha256(name.encode()).hexdigest())
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            holder.close()
            return None
    return holder
