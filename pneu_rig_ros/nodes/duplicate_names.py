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
import socket
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.serialization import deserialize_message

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes.diagnostics import PROCESS_KEY, process_id
from pneu_rig_ros.nodes.rig_node import RigNode
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
    Watches for duplicates of the nodes of this process.

    :param nodes: all nodes of the process; only those that must be unique are watched
    """

    def __init__(self, nodes: Sequence[RigNode]) -> None:
        self._nodes = {node.get_fully_qualified_name(): node for node in nodes if node.unique}
        domain = nodes[0].context.get_domain_id()
        self._locks = [HostLock(f'{domain}:{name}') for name in self._nodes]
        self._diagnostics = PolledSubscription(nodes[0], DIAGNOSTICS)
        self._last_seen: dict[str, float] = {}

    def update(self) -> None:
        """Take the waiting diagnostics and set `has_duplicate` of each node."""
        for cdr in self._diagnostics.take_all():
            message: Any = deserialize_message(cdr, DiagnosticArray)
            for status in message.status:
                process = {item.key: item.value for item in status.values}.get(PROCESS_KEY)
                if status.name in self._nodes and process not in (None, process_id()):
                    self._last_seen[status.name] = time.monotonic()
        for name, node in self._nodes.items():
            age = time.monotonic() - self._last_seen.get(name, -VALIDITY)
            node.has_duplicate = age < VALIDITY

    def check(self, keep_waiting: Callable[[], bool]) -> None:
        """
        Return when no node has a duplicate that was started earlier.

        :param keep_waiting: ends the check early when it returns False
        :raises RigError: when a node has a duplicate
        """
        start = time.monotonic()
        while keep_waiting() and time.monotonic() - start < self._timeout():
            self.update()
            for name, node in self._nodes.items():
                if node.has_duplicate:
                    raise RigError(
                        f'another {name} is running: give this rig a namespace '
                        '(-r __ns:=/left) or another ROS_DOMAIN_ID'
                    )
            time.sleep(0.02)

    def _timeout(self) -> float:
        """Return how long to wait [s]; acquires all names that are free on this computer."""
        acquired = [lock.acquire() for lock in self._locks]
        if not all(acquired):
            return TIMEOUT_ON_HOST
        for node in self._nodes.values():
            names = node.get_node_names_and_namespaces()
            if names.count((node.get_name(), node.get_namespace())) > 1:
                return TIMEOUT_IN_GRAPH
        return TIMEOUT

    def close(self) -> None:
        """Release the names."""
        for lock in self._locks:
            lock.release()


class HostLock:
    """
    A name that only one process of this computer holds at a time.

    It is the address of a socket in Linux's abstract namespace (unix(7)): no file is left behind,
    the kernel releases it however the process ends, and containers with a network of their own,
    which DDS does not reach either, do not share it.
    """

    def __init__(self, name: str) -> None:
        self._address = LOCK_PREFIX + hashlib.sha256(name.encode()).hexdigest()
        self._socket: socket.socket | None = None

    def acquire(self) -> bool:
        """Return False if another holds the name, else hold it; always True outside Linux."""
        if self._socket is not None or sys.platform != 'linux':
            return True
        attempt = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            attempt.bind(self._address)
        except OSError as error:
            attempt.close()
            return error.errno != errno.EADDRINUSE
        self._socket = attempt
        return True

    def release(self) -> None:
        """Let others acquire the name."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None
