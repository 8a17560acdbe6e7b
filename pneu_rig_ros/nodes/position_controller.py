"""The position controller node: PID or sliding mode, from `joint_states` to `u`."""

import math
from collections.abc import Iterator
from functools import partial
from typing import Any, cast

from pneu_rig_ros.control.controller import (
    NONE,
    Compensation,
    Law,
    Pid,
    PositionController,
    SlidingMode,
)
from pneu_rig_ros.control.excitation import REFERENCE, Excitation, load_excitation
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.quantity import Quantity, specifications
from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.diagnostics import NodeStatus
from pneu_rig_ros.nodes.rig_node import Parameter, RigNode
from pneu_rig_ros.nodes.samples import SampleClock
from pneu_rig_ros.records.cdr_decoding import JointReading, unpack_float64, unpack_joint_state
from pneu_rig_ros.records.cdr_encoding import pack_float64

LAWS: dict[str, type[Law]] = {'pid': Pid, 'sliding_mode': SlidingMode}


def _section_parameters(section: Any) -> Iterator[Parameter]:
    """Yield a parameter for each quantity of a section with defaults."""
    for name, quantity in specifications(section).items():
        yield Parameter.of(name, cast(Quantity, quantity), section._field_defaults[name])


class PositionControllerNode(RigNode):
    """
    Answers each sample with a command `u` [V] that moves the piston to the reference.

    The reference is a profile, which is also published on `reference`; or it is received on
    `reference`, and before the first message it is `setpoint`. Of the rig only `joint_states` is
    needed.
    """

    NAME = 'position_controller'
    PARAMETERS = (
        Parameter('law', 'pid', 'control law', choices=tuple(LAWS)),
        Parameter('compensation', True, 'whether friction and valve overlap are compensated'),
        Parameter('profile', '', 'position reference over time; empty: subscribe to reference'),
        Parameter('setpoint', 0.1, 'initial reference', 'm', 0.0, 10.0, read_only=False),
        Parameter('command_limit', 2.5, 'largest command', 'V', 0.0, 2.5),
        *_section_parameters(Pid),
        *_section_parameters(SlidingMode),
        *_section_parameters(Compensation),
    )

    def set_up(self) -> None:
        """Make the controller, load the profile; create publishers and subscriptions."""
        law = self._section(LAWS[self.text('law')])
        compensation = self._section(Compensation) if self.flag('compensation') else NONE
        self._controller = PositionController(law, compensation, self.number('command_limit'))
        self._profile = self._load_profile()
        self._command = self.add_publisher('u').publish
        self._publish_reference = self.add_publisher(REFERENCE).publish if self._profile else None
        self._references = None if self._profile else self.subscribe(REFERENCE)
        self._samples = self.subscribe('joint_states')
        self._reference: float | None = None
        self._sample_clock = SampleClock()
        self._errors: list[float] = []

    def _section(self, section: Any) -> Any:
        """Return a section with the values of its parameters."""
        return section(*map(self.number, section._fields))

    def _load_profile(self) -> Excitation | None:
        if not self.text('profile'):
            return None
        profile = load_excitation(self.text('profile'))
        if profile.drives != REFERENCE:
            raise RigError(
                f'position_controller: profile {profile.name} drives {profile.drives}, '
                f'allowed is one that drives {REFERENCE}'
            )
        return profile

    def update(self) -> None:
        """Answer the waiting samples."""
        if not self.ready():
            return
        if self._references:
            for reference in self.take_decoded(self._references, unpack_float64):
                if math.isfinite(reference):
                    self._reference = reference
                else:
                    self.refuse(f'reference {reference}, ignored')
        for reading in self.take_decoded(self._samples, unpack_joint_state):
            if math.isfinite(reading.position) and math.isfinite(reading.velocity):
                self._answer(reading)
            else:
                self.refuse('joint_states without finite position and velocity, ignored')

    def _answer(self, reading: JointReading) -> None:
        self._sample_clock.update(reading.stamp_ns)
        if self._profile:
            reference = self._profile.level(self._sample_clock.elapsed)
        else:
            reference = self.number('setpoint') if self._reference is None else self._reference
        interval = self._sample_clock.interval
        u = self._controller.update(interval, reference, reading.position, reading.velocity)
        if self._publish_reference:
            self._publish_reference(pack_float64(reference))
        self._command(pack_float64(u))
        self._errors.append(reference - reading.position)
        self.rate.count += 1

    def status(self) -> NodeStatus:
        """Return law and error for `/diagnostics`."""
        errors, self._errors = self._errors, []
        rms = math.sqrt(sum(e * e for e in errors) / len(errors)) if errors else math.nan
        values: dict[str, object] = {
            'law': self.text('law'),
            'error, rms of the last second [mm]': f'{rms * 1e3:.3f}',
        }
        state = 'running' if self._sample_clock.started else 'waiting for joint_states'
        return NodeStatus(state, values)


main = partial(runner.main, [PositionControllerNode])

if __name__ == '__main__':
    raise SystemExit(main())
