"""The valve command node: Eq. 1, from the command u to the voltages of both valves."""

import time
from collections.abc import Mapping
from typing import Any

from rclpy.context import Context

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.pacing import Arrivals, Pace
from pneu_rig_ros.nodes.parameters import Parameter
from pneu_rig_ros.nodes.rates import Rate
from pneu_rig_ros.nodes.rig_node import Report, RigNode
from pneu_rig_ros.nodes.senders import Senders
from pneu_rig_ros.records.cdr import pack_valve_voltages, unpack_float64, unpack_stamp
from pneu_rig_ros.rig.valve_drive import valve_voltages

LEAST_GAP_NS = 500_000
"""Between two turns [ns]: half a sampling interval, however fast commands come."""

FLOOD_HZ = 2000.0
"""Commands a second of which diagnostics warn: more than two a sample are of no use."""

ON_COMMAND, ON_SAMPLE = 'command', 'sample'


class ValveCommandNode(RigNode):
    """
    Answers each command `u` [V] with `valve_voltages` [V].

    A command that is not finite is refused and the last valid one stays; without any command for
    `command_timeout` u falls to 0, also after a start, as the valves may still be open. Of several
    commands that wait the newest is answered, whoever sent it. With trigger `sample` it answers
    each sample instead, from the first command on, and time is that of the samples: lock step
    without a controller in the loop.
    """

    PARAMETERS = (
        Parameter(
            'command_timeout',
            0.5,
            'time without a command after which u falls to 0; 0: never',
            's',
            0.0,
            3600.0,
            read_only=False,
        ),
        Parameter(
            'trigger',
            ON_COMMAND,
            'what each pair of voltages answers',
            choices=(ON_COMMAND, ON_SAMPLE),
        ),
    )

    def __init__(
        self, context: Context | None = None, overrides: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__('valve_command', context, overrides)
        self._publish = self.outlet('valve_voltages').publish
        self._commands = self.inlet('u')
        by_sample = self.text('trigger') == ON_SAMPLE
        self._samples = self.inlet('joint_states') if by_sample else None
        self._u: float | None = None
        self._senders = Senders()
        self._command_ns = time.monotonic_ns()
        self._now_ns = 0
        self._rate = Rate()
        self._commanded = Rate()
        self._refused = 0

    def work(self) -> None:
        """Answer what waits."""
        if not self.ready():
            return
        if self._samples is None:
            self._now_ns = time.monotonic_ns()
        answerable = self._take_commands()
        if self._samples is not None:
            self._answer_samples()
        elif answerable or self._timed_out():
            self._answer()

    def pace(self) -> Pace:
        """Return the pace of the commands, which may be slower than they come."""
        gap_ns = LEAST_GAP_NS if self._samples is None and not self.simulated_time else 0
        return Arrivals(self.inlets, self.context, gap_ns)

    def _take_commands(self) -> bool:
        """Take over the newest valid command; return whether there was one."""
        valid = False
        for arrival in self._commands.arrivals():
            self._senders.note(arrival.number)
            self._commanded.count += 1
            valid = self._accepts(arrival.cdr) or valid
        return valid

    def _answer_samples(self) -> None:
        """Answer the samples that wait; before the first command there is nothing to answer."""
        assert self._samples is not None
        while self._u is not None and (cdr := self._samples.take()) is not None:
            with self.refusing(self._samples):
                self._now_ns = unpack_stamp(cdr)
                self._timed_out()
                self._answer()

    def _accepts(self, cdr: bytes) -> bool:
        """Take over a command, or warn and return False."""
        try:
            u = unpack_float64(cdr)
            valve_voltages(u)
        except (RigError, ValueError) as error:
            self._refused += 1
            kept = f'keeping {self._u or 0.0:g} V'
            self.get_logger().warning(f'{error}; {kept}', throttle_duration_sec=1.0)
            return False
        self._u = u
        self._command_ns = self._now_ns
        return True

    def _timed_out(self) -> bool:
        """Let u fall to 0 when the last command is too old; return whether it just fell."""
        timeout = self.number('command_timeout')
        if not timeout or self._now_ns - self._command_ns <= timeout * 1e9:
            return False
        if self._u == 0.0 or (self._u is None and self.simulated_time):
            return False
        if self._u:
            told = f'no command for {timeout:g} s, u falls from {self._u:g} to 0 V'
            self.get_logger().warning(told)
        self._u = 0.0
        return True

    def _answer(self) -> None:
        self._publish(pack_valve_voltages(*valve_voltages(self._u or 0.0)))
        self._rate.count += 1

    def report(self) -> Report:
        """Return rate, present command and refused commands for `/diagnostics`."""
        commanded = self._commanded.per_second()
        values: dict[str, object] = {
            'rate [Hz]': f'{self._rate.per_second():.2f}',
            'commands [Hz]': f'{commanded:.2f}',
            'published': self._rate.count,
            'u [V]': self._u,
            'refused commands': self._refused,
        }
        newest = 'the newest command counts'
        return Report.of(
            'waiting' if self._u is None else 'running',
            values,
            warnings=(
                f'u comes from several publishers, {newest}' if self._senders.several else None,
                f'u comes {commanded:.0f} times a second, {newest}'
                if commanded > FLOOD_HZ
                else None,
            ),
        )


def main() -> int:
    """Run the node until Ctrl-C; return the exit code."""
    return runner.main([ValveCommandNode])


if __name__ == '__main__':
    raise SystemExit(main())
