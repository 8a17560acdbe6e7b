"""
Two nodes of one name: two rigs in one namespace, whose messages would be mixed.

Every node says its name and process on /diagnostics once a second. Whoever hears its own name from
another process has a twin. A node that starts beside its twin gives way; one that died leaves its
name in the graph for a while, but is not heard, so that its successor starts. A busy computer
takes a while until nodes see each other, but that a twin on it is there shows at once.
"""

import os
import socket
import time
from collections.abc import Callable, Sequence
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.serialization import deserialize_message

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes.host_claim import HostClaim
from pneu_rig_ros.nodes.rig_node import RigNode
from pneu_rig_ros.nodes.wiring import Inlet
from pneu_rig_ros.records.topics import DIAGNOSTICS

PROCESS = 'process'
"""Key on /diagnostics of who speaks."""

FIRST_SIGHT, HEARING, HEARING_HERE = 0.5, 2.0, 20.0
"""
How long a twin is listened for at the start: when nothing hints at it, when the graph knows its
name, and when it is on this computer [s].
"""

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
        domain = nodes[0].context.get_domain_id()
        self._claims = [HostClaim(f'{domain}:{name}') for name in self._nodes]
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

    def give_way(self, wanted: Callable[[], bool]) -> None:
        """
        Return when it is certain that no node has a twin that was there before.

        :param wanted: asked while it listens; it ends early when not
        :raises RigError: when one has
        """
        start = time.monotonic()
        while wanted() and time.monotonic() - start < self._patience():
            self.listen()
            for name, node in self._nodes.items():
                if node.has_twin:
                    raise RigError(
                        f'another {name} is running: give this rig a namespace '
                        '(-r __ns:=/left) or another ROS_DOMAIN_ID'
                    )
            time.sleep(0.02)

    def _patience(self) -> float:
        """Return how long to listen [s]; the names that are free on this computer are taken."""
        elsewhere = [claim.held_elsewhere() for claim in self._claims]
        if any(elsewhere):
            return HEARING_HERE
        return HEARING if any(map(_namesake, self._nodes.values())) else FIRST_SIGHT

    def close(self) -> None:
        """Make room for others."""
        for claim in self._claims:
            claim.release()


def _namesake(node: RigNode) -> bool:
    """Return whether the graph knows the name of a node twice."""
    known = node.get_node_names_and_namespaces()
    return bool(known.count((node.get_name(), node.get_namespace())) > 1)
