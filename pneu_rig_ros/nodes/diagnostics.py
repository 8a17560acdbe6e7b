"""`/diagnostics` at 1 Hz from what a node reports."""

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from pneu_rig_ros.nodes import wiring
from pneu_rig_ros.nodes.rig_node import RigNode
from pneu_rig_ros.nodes.twins import PROCESS, own_process
from pneu_rig_ros.records.topics import DIAGNOSTICS

PERIOD_NS = 1_000_000_000


class Diagnostics:
    """Publishes the report of one node once a second."""

    def __init__(self, node: RigNode) -> None:
        self._node = node
        self._publisher = wiring.outlet(node, DIAGNOSTICS)
        self._due = 0

    def publish_if_due(self, now_ns: int) -> None:
        """Publish the node's report unless the last one is younger than a second."""
        if now_ns >= self._due:
            self._due = now_ns + PERIOD_NS
            self.publish()

    def publish(self) -> None:
        """Publish the node's report now."""
        report = self._node.full_report()
        values = {**report.values, PROCESS: own_process()}
        if self._node.malformed:
            values['malformed messages'] = self._node.malformed
        status = DiagnosticStatus(
            level=report.level,
            name=self._node.get_fully_qualified_name(),
            message=report.summary,
            values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)
