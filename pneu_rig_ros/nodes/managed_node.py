"""Nodes with the states of the ROS 2 lifecycle."""

from collections.abc import Callable
from typing import Any, ClassVar

from rclpy.context import Context
from rclpy.lifecycle import LifecycleNodeMixin, LifecycleState
from rclpy.lifecycle import TransitionCallbackReturn as Outcome

from pneu_rig_ros.errors import LONGEST_LINE, one_line
from pneu_rig_ros.nodes.rig_node import COMMON, Overrides, Parameter, RigNode


class ManagedNode(LifecycleNodeMixin, RigNode):
    """
    A node that `ros2 lifecycle` or a launch file configures, activates and deactivates.

    With `autostart` it is active as soon as it is made. Subclasses say what happens: `set_up`
    reads, compiles and creates publishers and subscriptions; `update` runs while the node is
    active, between `start` and `stop`; `finish` writes what is unwritten.
    """

    SHARED: ClassVar[tuple[Parameter, ...]] = (
        *COMMON,
        Parameter('autostart', True, 'whether the node configures and activates itself'),
    )

    def __init__(self, context: Context | None = None, overrides: Overrides = None) -> None:
        self.active = self.configured = self._made = False
        RigNode.__init__(self, context, overrides)

    def begin(self) -> None:
        """Offer the transitions; go through the first two with `autostart`."""
        LifecycleNodeMixin.__init__(self)
        if self.flag('autostart'):
            for trigger in (self.trigger_configure, self.trigger_activate):
                trigger()
                if self._error is not None:
                    raise self._error
        self._made = True

    # What a node does, after `set_up`.

    def start(self) -> None:
        """Begin; messages that came while the node was not active have been discarded."""

    def stop(self) -> None:
        """Pause, in a state in which the rig is safe."""

    def finish(self) -> None:
        """Write what is unwritten, before publishers and subscriptions are destroyed."""

    def add_service(self, kind: type, name: str, answer: Callable[[Any, Any], Any]) -> None:
        """Create a service."""
        self._owned.callback(self.destroy_service, self.create_service(kind, name, answer))

    def release(self) -> None:
        """Destroy publishers, subscriptions and services."""
        self._ready = False
        self._volatile_publishers.clear()
        self.polled_subscriptions.clear()
        self._owned.close()

    # The transitions. Only configure and activate can fail; of others an error is logged.

    def on_configure(self, _: LifecycleState) -> Outcome:
        """Set up the node; one that cannot be set up stays unconfigured."""
        outcome = self._attempt(self.set_up)
        self.configured = outcome is Outcome.SUCCESS
        if not self.configured:
            self.release()
        return outcome

    def on_activate(self, _: LifecycleState) -> Outcome:
        """Let the node run."""
        outcome = self._attempt(self._discard_waiting, self.start)
        self.active = outcome is Outcome.SUCCESS
        return outcome

    def on_deactivate(self, _: LifecycleState) -> Outcome:
        """Pause the node."""
        self.active = False
        self._attempt(self.stop)
        return Outcome.SUCCESS

    def on_cleanup(self, _: LifecycleState) -> Outcome:
        """Undo the set-up."""
        self.configured = False
        self._attempt(self.finish)
        self.release()
        return Outcome.SUCCESS

    def on_shutdown(self, _: LifecycleState) -> Outcome:
        """End the work of the node from any state."""
        self._attempt(self.close)
        self.active = self.configured = False
        self.release()
        return Outcome.SUCCESS

    def close(self) -> None:
        """Stop and finish, whatever the state."""
        if self.active:
            self.stop()
        if self.configured:
            self.finish()

    def _attempt(self, *steps: Callable[[], None]) -> Outcome:
        """Do the steps; of an exception rclpy would keep only that there was one."""
        self._error: Exception | None = None
        try:
            for step in steps:
                step()
        except Exception as error:
            self._error = error
            if self._made:
                self.get_logger().error(one_line(str(error), LONGEST_LINE))
            return Outcome.FAILURE
        return Outcome.SUCCESS

    def _discard_waiting(self) -> None:
        for subscription in self.polled_subscriptions:
            subscription.sequence.resume()
            if not subscription.topic.transient_local:
                for _ in subscription.take_all():
                    pass
