"""
Two nodes of one name: two rigs in one namespace, whose messages would be mixed.

Every node says its name and process on /diagnostics once a second. Whoever hears its own name from
another process has a twin. A node that starts beside its twin gives way; one that died leaves its
name in the graph for a while, but is not heard, so that its successor starts.
"""

import os
import socket
import time
from collections.abc import Sequence
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.serialization import deserialize_message

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes.rig_node import RigNode
from pneu_rig_ros.nodes.wiring import Inlet
from pneu_rig_ros.records.topics import DIAGNOSTICS

PROCESS = 'process'
"""Key on /diagnostics of who speaks."""

FIRST_SIGHT, HEARING = 0.5, 2.0
"""How long a twin is looked for at the start, and listened for when there is its name [s]."""

MEMORY = 5.0
"""How long after its last word a twin counts [s]."""


def own_process() -> str:
    """Return what tells this process from all others."""
    return f'{os.getpid()}@{socket.gethostname()}'


class Twins:
    """
    Watches out for the twins of the nodes of this process.

    :param nodes: those of which there may be only one of a name
    """

    def __init__(self, nodes: Sequence[RigNode]) -> None:
        self._nodes = {node.get_fully_qualified_name(): node for node in nodes if node.unique}
        self._inlet = Inlet(nodes[0], DIAGNOSTICS)
        self._heard: dict[str, float] = {}

    def listen(self) -> None:
        """Take what was said since the last time, and let each node know whether it has a twin."""
        for cdr in self._inlet.take_all():
            message: Any = deserialize_message(cdr, DiagnosticArray)
            for status in message.status:
                speaker = {item.key: item.value for item in status.values}.get(PROCESS)
                if status.name in self._nodes and speaker not in (None, own_process()):
                    self._heard[status.name] = time.monotonic()
        for name, node in self._nodes.items():
            node.has_twin = time.monotonic() - self._heard.get(name, -MEMORY) < MEMORY

    def give_way(self) -> None:
        """
        Return when it is certain that no node has a twin that was there before.

        :raises RigError: when one has
        """
        start = time.monotonic()
        while (elapsed := time.monotonic() - start) < HEARING:
            self.listen()
            for name, node in self._nodes.items():
                if node.has_twin:
                    raise RigError(
                        f'another {name} is running: give this rig a namespace '
                        '(-r __ns:=/left) or another ROS_DOMAIN_ID'
                    )
            if elapsed > FIRST_SIGHT and not any(map(_namesake, self._nodes.values())):
                return
            time.sleep(0.02)


def _namesake(node: RigNode) -> bool:
    """Return whether the graph knows the name of a node twice."""
    known = node.get_node_names_and_namespaces()
    return bool(known.count((node.get_name(), node.get_namespace())) > 1)
