"""Clocks that jump: what was measured before and after is in order."""

from typing import Any

import pytest
from rclpy.context import Context

from pneu_rig_ros.control.excitation import load_excitation
from pneu_rig_ros.nodes import timing
from pneu_rig_ros.nodes.excitation import ExcitationNode
from pneu_rig_ros.nodes.position_controller import PositionControllerNode
from pneu_rig_ros.nodes.samples import SampleClock
from pneu_rig_ros.nodes.timing import WallClock
from pneu_rig_ros.records.cdr_decoding import unpack_float64
from pneu_rig_ros.records.cdr_encoding import template

from .bystander import Bystander, gather

HOUR = 3600 * 10**9


class Clocks:
    """A monotonic clock that the test moves, and a wall clock that it sets."""

    def __init__(self) -> None:
        self.elapsed = 0
        self.set_by = 1_800_000_000 * 10**9

    def monotonic_ns(self) -> int:
        return self.elapsed

    def time_ns(self) -> int:
        return self.elapsed + self.set_by


@pytest.fixture
def clocks(monkeypatch: pytest.MonkeyPatch) -> Clocks:
    made = Clocks()
    monkeypatch.setattr(timing, 'time', made)
    return made


@pytest.mark.parametrize('jump', [HOUR, -HOUR, 6_000_000])
def test_readings_go_on_evenly_when_it_is_set(clocks: Clocks, jump: int) -> None:
    clock, start = WallClock(), clocks.time_ns()
    readings = []
    for tick in range(10):
        clocks.elapsed += 20_000_000
        readings.append(clocks.time_ns())
        if tick == 4:
            clocks.set_by += jump  # after this tick's message was received, before it is taken
        clock.update()
        readings[-1] = clock.without_steps(readings[-1])
    assert readings == [start + 20_000_000 * (tick + 1) for tick in range(10)]
    assert clock.step_ns == jump
    assert clock.warning('stamps') == (
        f'wall clock set by {jump * 1e-9:+.3f} s, stamps are not affected'
    )


def test_an_interrupted_process_is_no_jump(clocks: Clocks) -> None:
    clock = WallClock()
    clocks.set_by += 1_000_000
    clock.update()
    assert clock.step_ns == 0
    assert clock.warning('stamps') is None


def test_a_clock_that_was_set_back_again_is_right(clocks: Clocks) -> None:
    clock = WallClock()
    for jump in (HOUR, -HOUR):
        clocks.set_by += jump
        clock.update()
    clock.update()
    assert clock.warning('stamps') is None
    assert clock.without_steps(clocks.time_ns()) == clocks.time_ns()


@pytest.mark.parametrize('jump', [HOUR, -HOUR])
def test_a_message_stamped_between_a_setting_and_the_next_look_is_in_order(
    clocks: Clocks, jump: int
) -> None:
    clock, start = WallClock(), clocks.time_ns()
    clock.update()
    clocks.set_by += jump
    clocks.elapsed += 20_000_000
    assert clock.without_steps(clocks.time_ns()) == start + 20_000_000


def test_time_of_samples_starts_again_where_stamps_jump_back() -> None:
    clock, times = SampleClock(), []
    assert not clock.started
    for seconds in (5, 6, 8, 8, 2, 3):
        clock.update(seconds * 10**9)
        times.append((clock.elapsed, clock.interval))
    assert times == [(0, 0), (1, 1), (3, 2), (3, 0), (0, 0), (1, 1)]


@pytest.mark.live
@pytest.mark.parametrize(
    ('kind', 'profile'), [(ExcitationNode, 'ramp'), (PositionControllerNode, 'reference_sine')]
)
def test_profile_starts_again_where_stamps_jump_back(
    kind: Any, profile: str, context: Context, bystander: Bystander, loop_of: Any
) -> None:
    excitation, message = load_excitation(profile), template('joint_states')
    levels, commands = bystander.hear(excitation.drives), bystander.hear('u')
    runner = loop_of(kind(context, {'profile': profile, 'wait_for_subscribers': 1}))
    publish = bystander.speak('joint_states')
    for seconds in (5, 8, 2, 3):
        publish(message.at(seconds * 10**9, 0.1, 0.0))
    heard, _ = gather(runner, [levels, commands], 4)
    assert [unpack_float64(cdr) for cdr in heard] == [excitation.level(t) for t in (0, 3, 0, 1)]
