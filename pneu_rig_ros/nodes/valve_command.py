"""The valve command node: the voltages of both valves from the command u, by Eq. 1."""

import time
from collections.abc import Iterable
from functools import partial

from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.diagnostics import NodeStatus, RateCounter
from pneu_rig_ros.nodes.managed_node import ManagedNode
from pneu_rig_ros.nodes.rig_node import Parameter
from pneu_rig_ros.nodes.timing import LoopTimer, MessageWaitSet
from pneu_rig_ros.nodes.topics import PolledSubscription
from pneu_rig_ros.records.cdr_decoding import unpack_float64, unpack_stamp
from pneu_rig_ros.records.cdr_encoding import pack_valve_voltages
from pneu_rig_ros.rig.valve_drive import checked_command, valve_voltages

LEAST_INTERVAL_NS = 500_000
"""Shortest time between two answers in real time [ns], at any rate of commands."""

HIGHEST_RATE = 2000.0
"""Diagnostics warn of a higher rate of commands [Hz]: more than two per sample are useless."""

ON_COMMAND, ON_SAMPLE = 'command', 'sample'


class ValveCommandNode(ManagedNode):
    """
    Answers each command `u` [V] with `valve_voltages` [V].

    A command that is not finite or beyond 1000 V is rejected and the last valid one stays; in
    simulated time it is answered with that one, as a plant in lock step waits for it. Without
    a valid one for `command_timeout` u is set to 0, also after a start, because the valves may
    still be open. Of several waiting commands the newest is answered, from any publisher. With
    trigger `sample` the node answers each sample from the first command on, and the timeout is in
    the time of the samples: lock step without a controller in the loop.
    """

    NAME = 'valve_command'
    PARAMETERS = (
        Parameter(
            'command_timeout',
            0.5,
            'time without a valid command after which u is set to 0; 0: never',
            's',
            0.0,
            3600.0,
            read_only=False,
        ),
        Parameter('trigger', ON_COMMAND, 'message to answer', choices=(ON_COMMAND, ON_SAMPLE)),
    )

    def set_up(self) -> None:
        """Create publisher and subscriptions."""
        self._publish = self.add_publisher('valve_voltages').publish
        self._commands = self.subscribe('u')
        by_sample = self.text('trigger') == ON_SAMPLE
        self._samples = self.subscribe('joint_states') if by_sample else None
        self._command_rate = RateCounter()

    def start(self) -> None:
        """Wait for a command."""
        self._u: float | None = None
        self._command_ns = time.monotonic_ns()
        self._now_ns = 0

    def stop(self) -> None:
        """Close the valves if they are open."""
        if self._u:
            self._u = 0.0
            self._answer()

    def close(self) -> None:
        """Close the valves, but in simulated time, where each answer belongs to a sample."""
        if not self.simulated_time:
            super().close()

    def loop_timer(self) -> LoopTimer:
        """Return a wait set with a least interval between two answers."""
        gap_ns = LEAST_INTERVAL_NS if self._samples is None and not self.simulated_time else 0
        return MessageWaitSet(self.awaited, self.context, gap_ns)

    def inputs(self) -> Iterable[PolledSubscription]:
        """Return the subscriptions; no sample is taken before the first command."""
        return [self._commands] if self._u is None else self.polled_subscriptions

    def update(self) -> None:
        """Answer the newest command, or with trigger `sample` each waiting sample."""
        if not self.ready():
            return
        if self._samples is None:
            self._now_ns = time.monotonic_ns()
            if self._take_commands() or self._timed_out():
                self._answer()
            return
        self._take_commands()
        while self._u is not None and (cdr := self._samples.take()) is not None:
            with self.skip_invalid(self._samples):
                self._now_ns = unpack_stamp(cdr)
                # stamps jump back where a simulation is restarted: the age counts from there
                self._command_ns = min(self._command_ns, self._now_ns)
                self._timed_out()
                self._answer()

    def _take_commands(self) -> bool:
        """Take the newest valid command; return whether the voltages are to be published."""
        answer = False
        for cdr in self._commands.take_all():
            self._command_rate.count += 1
            answer = answer or self.simulated_time
            with self.skip_invalid(self._commands, f'keeping {self._u or 0.0:g} V'):
                self._u = checked_command(unpack_float64(cdr))
                self._command_ns = self._now_ns
                answer = True
        return answer

    def _timed_out(self) -> bool:
        """Set u to 0 if the last command is too old; return whether it was set."""
        timeout = self.number('command_timeout')
        if not timeout or self._now_ns - self._command_ns <= timeout * 1e9:
            return False
        if self._u == 0.0 or (self._u is None and self.simulated_time):
            return False
        if self._u:
            warning = f'no command for {timeout:g} s, u is set from {self._u:g} to 0 V'
            self.get_logger().warning(warning)
        self._u = 0.0
        return True

    def _answer(self) -> None:
        self._publish(pack_valve_voltages(*valve_voltages(self._u or 0.0)))
        self.rate.count += 1

    def status(self) -> NodeStatus:
        """Return the present command and its rate for `/diagnostics`."""
        rate = self._command_rate.update()
        values: dict[str, object] = {
            'commands [Hz]': f'{rate:.2f}',
            'published': self.rate.count,
            'u [V]': self._u,
        }
        newest = 'the newest command counts'
        several = self._commands.sequence.alternating
        warnings = (
            f'u comes from several publishers, {newest}' if several else None,
            f'u comes {rate:.0f} times a second, {newest}' if rate > HIGHEST_RATE else None,
        )
        return NodeStatus('waiting' if self._u is None else 'running', values, warnings)


main = partial(runner.main, [ValveCommandNode])

if __name__ == '__main__':
    raise SystemExit(main())
