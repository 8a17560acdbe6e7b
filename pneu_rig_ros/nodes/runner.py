"""Runs nodes: one loop for their work, services and diagnostics, and a clean end."""

import gc
import inspect
import os
import signal
import sys
import time
from collections.abc import Callable, Sequence

import rclpy
from rclpy._rclpy_pybind11 import RCLError, UnknownROSArgsError
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from pneu_rig_ros.errors import LONGEST_LINE, RigError, one_line
from pneu_rig_ros.nodes import OWNER
from pneu_rig_ros.nodes.diagnostics import Diagnostics
from pneu_rig_ros.nodes.pacing import claim_realtime_priority
from pneu_rig_ros.nodes.rig_node import RigNode
from pneu_rig_ros.nodes.twins import Twins

SERVICE_PERIOD_NS = 100_000_000
"""Services and parameters are served ten times a second, which costs the ticks next to nothing."""

Factory = Callable[[Context], RigNode]


class Runner:
    """
    The loop around one or more nodes of one process; the first one sets the pace.

    :param nodes: which to run, all of one context
    """

    def __init__(self, nodes: Sequence[RigNode]) -> None:
        self.nodes = nodes
        self._executor = SingleThreadedExecutor(context=nodes[0].context)
        for node in nodes:
            self._executor.add_node(node)
            node.expect(nodes)
        self.twins = Twins(nodes)
        self._diagnostics = [Diagnostics(node) for node in nodes]
        self._due = [0] * len(nodes)
        self._service_due = 0
        self._pace = nodes[0].pace()

    def run(self, wanted: Callable[[], bool]) -> None:
        """Loop for as long as `wanted()` and ROS is up."""
        context = self.nodes[0].context
        # rclpy scans all modules for the caller of its first log line: up to 80 ms, paid here.
        inspect.getmodule(inspect.currentframe())
        self._serve(time.monotonic_ns())
        while wanted() and context.ok():
            self._pace.wait()
            self.turn()

    def turn(self) -> None:
        """Let every node work that is due, then serve services if they are due."""
        now = time.monotonic_ns()
        for index, node in enumerate(self.nodes):
            if now >= self._due[index]:
                node.work()
                if index:
                    self._due[index] = now + node.period_ns
        if now >= self._service_due:
            self._serve(now)

    def _serve(self, now: int) -> None:
        """Serve one waiting service of each executor round, and report once a second."""
        self._service_due = now + SERVICE_PERIOD_NS
        self._executor.spin_once(timeout_sec=0)
        self.twins.listen()
        for diagnostics in self._diagnostics:
            diagnostics.publish_if_due(now)

    def close(self) -> None:
        """
        Let each node finish, report for the last time and be heard; then destroy them.

        :raises RigError: when one could not finish what it was for
        """
        failures: list[RigError] = []
        for node, diagnostics in zip(self.nodes, self._diagnostics, strict=True):
            try:
                node.close()
            except RigError as error:
                failures.append(error)
            diagnostics.publish()
            node.await_delivery()
        self._destroy()
        if failures:
            raise failures[0]

    def withdraw(self) -> None:
        """Destroy the nodes as if they had never been."""
        for node in self.nodes:
            node.withdraw()
        self._destroy()

    def _destroy(self) -> None:
        self._executor.shutdown()
        for node in self.nodes:
            node.destroy_node()
        self.twins.close()


def main(factories: Sequence[Factory]) -> int:
    """
    Run nodes as a process until SIGINT or SIGTERM; return the exit code.

    Signals only set a flag: ROS stays up until the nodes have finished, so that the recorder can
    take what still waits, and a second Ctrl-C cannot cut the end short.
    """
    context = Context()
    try:
        rclpy.init(args=sys.argv, context=context, signal_handler_options=SignalHandlerOptions.NO)
        return _run(factories, context)
    except (RigError, RCLError, UnknownROSArgsError) as error:
        # ROS itself refuses its arguments, and to run unprotected where security is asked for.
        print(f'Error: {one_line(str(error), LONGEST_LINE)}', file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 0
    finally:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)
        context.try_shutdown()


def _run(factories: Sequence[Factory], context: Context) -> int:
    stop: list[int] = []
    runner = Runner([factory(context) for factory in factories])
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda received, _: stop.append(received))
    _claim_priority(runner.nodes)
    # What exists now lives until the end: the collector need not look at it again.
    gc.collect()
    gc.freeze()
    owner = os.environ.get(OWNER)

    def wanted() -> bool:
        orphaned = owner is not None and os.getppid() != int(owner)
        return not (stop or orphaned or any(node.done for node in runner.nodes))

    try:
        runner.twins.give_way(wanted)
    except RigError:
        runner.withdraw()
        raise
    try:
        runner.run(wanted)
    finally:
        runner.close()
    return 0


def _claim_priority(nodes: Sequence[RigNode]) -> None:
    priority = max(int(node.number('realtime_priority')) for node in nodes)
    trouble = claim_realtime_priority(priority)
    if trouble:
        nodes[0].get_logger().warning(trouble)
