"""Runs nodes: one loop for updates, services and diagnostics, and an orderly shutdown."""

import ctypes
import gc
import inspect
import os
import signal
import struct
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import rclpy
from rclpy._rclpy_pybind11 import RCLError, UnknownROSArgsError
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from pneu_rig_ros.errors import LONGEST_LINE, RigError, one_line
from pneu_rig_ros.nodes import OWNER
from pneu_rig_ros.nodes.duplicate_names import DuplicateNameGuard
from pneu_rig_ros.nodes.rig_node import RigNode
from pneu_rig_ros.nodes.timing import PeriodicTimer, claim_realtime_priority

SERVICE_PERIOD_NS = 100_000_000
"""Services and parameters are served ten times a second, which hardly delays the ticks."""

DIAGNOSTICS_PERIOD_NS = 1_000_000_000

IDLE_PERIOD_NS = 20_000_000
"""Between two cycles of the loop while the first node is not active."""

ACKNOWLEDGEMENT_TIMEOUT = 0.3
"""Longest wait for the acknowledgements of each topic at the end [s]."""

DESTRUCTION_TIMEOUT = 3
"""Longest time that the destruction of the nodes takes [s]; it is some 0.1 s."""

Factory = Callable[[Context], RigNode]


class Runner:
    """The loop of a process around its nodes, all of one context; the first one sets the rate."""

    def __init__(self, nodes: Sequence[RigNode]) -> None:
        self.nodes = nodes
        self._executor = SingleThreadedExecutor(context=nodes[0].context)
        for node in nodes:
            self._executor.add_node(node)
            node.process_nodes = nodes
        unique = [node.get_fully_qualified_name() for node in nodes if node.unique]
        self.duplicates = DuplicateNameGuard(nodes[0], unique)
        self._due = [0] * len(nodes)
        self._service_due = self._diagnostics_due = 0
        self._choose_timer()

    def _choose_timer(self) -> None:
        """Follow the first node; while it is not active, serve the transitions of all."""
        self._first_active = self.nodes[0].active
        idle = PeriodicTimer(IDLE_PERIOD_NS)
        self._timer = self.nodes[0].loop_timer() if self._first_active else idle

    def run(self, keep_running: Callable[[], bool]) -> None:
        """Loop until `keep_running()` returns False or ROS is shut down."""
        context = self.nodes[0].context
        # rclpy scans all modules for the caller of its first log line: up to 80 ms, paid here.
        inspect.getmodule(inspect.currentframe())
        self._serve(time.monotonic_ns())
        while keep_running() and context.ok():
            self._timer.wait()
            self.spin_once()

    def spin_once(self) -> None:
        """Update every node that is due, then serve services if they are due."""
        now = time.monotonic_ns()
        for index, node in enumerate(self.nodes):
            if now >= self._due[index] and node.active:
                node.update()
                if index:
                    self._due[index] = now + node.period_ns
        if now >= self._service_due:
            self._serve(now)

    def _serve(self, now: int) -> None:
        """Serve one waiting request, and publish diagnostics once a second."""
        self._service_due = now + SERVICE_PERIOD_NS
        self._executor.spin_once(timeout_sec=0)
        if self.nodes[0].active is not self._first_active:
            self._choose_timer()
        duplicates = self.duplicates.update()
        if now >= self._diagnostics_due:
            self._diagnostics_due = now + DIAGNOSTICS_PERIOD_NS
            for node in self.nodes:
                node.has_duplicate = node.get_fully_qualified_name() in duplicates
                node.publish_status()

    def close(self) -> None:
        """Finish and destroy the nodes; RigError when one could not complete its task."""
        try:
            self.finish()
        finally:
            self.destroy()

    def finish(self) -> None:
        """
        Close each node, publish its last diagnostics and wait for delivery.

        :raises RigError: when a node could not complete its task
        """
        failures: list[RigError] = []
        for node in self.nodes:
            try:
                node.close()
            except RigError as error:
                failures.append(error)
            node.publish_status()
            for publisher in node.publishers:
                publisher.wait_for_all_acked(Duration(seconds=ACKNOWLEDGEMENT_TIMEOUT))
        if failures:
            raise failures[0]

    def destroy(self) -> None:
        """Destroy the nodes."""
        self._executor.shutdown()
        for node in self.nodes:
            node.destroy_node()
        self.duplicates.close()


def main(factories: Sequence[Factory]) -> int:
    """
    Run nodes as a process until SIGINT or SIGTERM; return the exit code.

    While the nodes load, which may compile for long, signals end the process at once. Then they
    only set a flag: ROS stays up until the nodes have finished, so that the recorder can take the
    waiting messages, and a second Ctrl-C cannot interrupt the shutdown.
    """
    context, code = Context(), 0
    runner: Runner | None = None
    stop: list[int] = []
    try:
        rclpy.init(args=sys.argv, context=context, signal_handler_options=SignalHandlerOptions.NO)
        runner = Runner(_load(factories, context, stop))
        _run(runner, stop)
    except (RigError, RCLError, UnknownROSArgsError) as error:
        # ROS rejects its arguments, or a missing keystore where security is required.
        print(f'Error: {one_line(str(error), LONGEST_LINE)}', file=sys.stderr)
        code = 2
    except KeyboardInterrupt:
        pass  # while the nodes load
    finally:
        _handle_signals(signal.SIG_IGN)
        exit_after(DESTRUCTION_TIMEOUT, code)
        if runner is not None:
            runner.destroy()
        context.try_shutdown()
    return code


def _handle_signals(handler: Callable[[int, object], None] | signal.Handlers) -> None:
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, handler)


def _load(factories: Sequence[Factory], context: Context, stop: list[int]) -> list[RigNode]:
    """Create the nodes; a signal is appended to `stop` and ends this by KeyboardInterrupt."""

    def interrupt(received: int, _: object) -> None:
        stop.append(received)
        raise KeyboardInterrupt

    def report(unraisable: Any) -> None:
        # Callbacks of the compiler swallow the exception with a traceback; `stop` has the signal.
        if not isinstance(unraisable.exc_value, KeyboardInterrupt):
            sys.__unraisablehook__(unraisable)

    sys.unraisablehook = report
    _handle_signals(interrupt)
    nodes: list[RigNode] = []
    try:
        for factory in factories:
            nodes.append(factory(context))  # noqa: PERF401 - those made so far are undone
    except KeyboardInterrupt:
        _abort(nodes)
        raise
    _handle_signals(lambda received, _: stop.append(received))
    return nodes


def _abort(nodes: Iterable[RigNode]) -> None:
    for node in nodes:
        node.abort()


def _run(runner: Runner, stop: list[int]) -> None:
    """Run the nodes until a signal, the end of a node or that of the owner; then finish them."""
    priority = max(int(node.number('realtime_priority')) for node in runner.nodes)
    if refusal := claim_realtime_priority(priority):
        runner.nodes[0].get_logger().warning(refusal)
    # Objects created so far live until the end: exclude them from garbage collection.
    gc.collect()
    gc.freeze()
    owner = os.environ.get(OWNER)

    def keep_running() -> bool:
        orphaned = owner is not None and os.getppid() != int(owner)
        return not (stop or orphaned or any(node.done for node in runner.nodes))

    try:
        runner.duplicates.check(keep_running)
    except RigError:
        _abort(runner.nodes)
        raise
    try:
        runner.run(keep_running)
    finally:
        runner.finish()


SIGEV_THREAD = 2
"""A timer that calls a function, see sigevent(7)."""


def exit_after(seconds: int, code: int) -> None:
    """
    End this process after some time, whatever it does then; does nothing but on Linux.

    Fast DDS 2.14 may wait for itself forever, at full load, when a participant is destroyed while
    it learns that another one has ended: `DomainParticipant::set_listener` holds the mutex for
    which the callback waits that it waits for. Of nodes that get Ctrl-C together this is one in
    some 30. rclpy holds the interpreter lock meanwhile, so that no Python code can end the
    process: a timer of the operating system does (timer_create(2)).
    """
    if sys.platform != 'linux':
        return
    libc = ctypes.CDLL(None)
    function = ctypes.cast(libc._exit, ctypes.c_void_p).value
    event = struct.pack('PiiP40x', code, 0, SIGEV_THREAD, function)  # struct sigevent
    timer, delay = ctypes.c_void_p(), (ctypes.c_long * 4)(0, 0, seconds, 0)
    libc.timer_create(time.CLOCK_MONOTONIC, event, ctypes.byref(timer))
    libc.timer_settime(timer, 0, delay, None)
