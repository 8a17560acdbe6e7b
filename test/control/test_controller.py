"""The control laws in closed loop with the rig: limit cycles, and compensation that ends them."""

import functools

import numpy as np
import pytest
from tracking import tracking

from pneu_rig_ros.control.controller import (
    NONE,
    Compensation,
    Law,
    Pid,
    PositionController,
    SlidingMode,
)
from pneu_rig_ros.control.excitation import load_excitation
from pneu_rig_ros.rig import Rig, load_configuration
from pneu_rig_ros.rig.valve_drive import valve_voltages

CYLINDERS = ['cylinder_1', 'cylinder_2', 'cylinder_3']
STEPS = load_excitation('reference_steps')
SETTLED = ((12.0, 16.0), (20.0, 24.0), (28.0, 32.0))
"""The second half of each step but the first, on which the rig starts [s]."""
LOW_GAINS = Pid(60.0, 60.0, 2.0)
"""A rate so little fed back that its noise does not carry the valves across their overlap."""
SETPOINT = 0.1
"""Reference of the command in docs/controllers.md [m]."""


@functools.cache
def controlled(
    cylinder: str,
    law: Law,
    profile: str,
    compensated=True,
    fluid_time_constant: float | None = None,
):
    """Return interval, references and measured positions of a run in closed loop."""
    excitation = load_excitation(profile)
    configuration = load_configuration(cylinder, initial_position=excitation.level(0.0))
    if fluid_time_constant is not None:
        key, value = 'fluid_time_constant', fluid_time_constant
        configuration = configuration.with_parameter('friction', key, value)
    rig = Rig(configuration)
    samples = round(min(excitation.duration, 32.0) / rig.interval)
    reference = np.array([excitation.level(k * rig.interval) for k in range(samples)])
    return rig.interval, reference, closed_loop(rig, law, reference, compensated)


def closed_loop(rig: Rig, law: Law, reference, compensated: bool):
    """Return the measured positions [m] of a rig that is to follow the reference [m]."""
    controller = PositionController(law, Compensation() if compensated else NONE)
    samples = len(reference)
    position = np.empty(samples)
    for k in range(samples):
        sample = rig.sample
        position[k] = sample.position
        interval = rig.interval if k else 0.0
        u = controller.update(interval, reference[k], sample.position, sample.velocity)
        rig.step(*valve_voltages(u))
    return position


def settled(run):
    """Return the figures of the parts in which the piston should rest."""
    interval, reference, position = run
    parts = [slice(round(a / interval), round(b / interval)) for a, b in SETTLED]
    return [tracking(reference[part], position[part], interval) for part in parts]


def test_a_bare_pid_hunts_and_compensation_ends_it() -> None:
    bare = settled(controlled('cylinder_3', LOW_GAINS, 'reference_steps', compensated=False))
    compensated = settled(controlled('cylinder_3', LOW_GAINS, 'reference_steps'))
    assert sum(figures.slips for figures in bare) >= 2
    assert all(13e-3 < figures.wander < 18e-3 for figures in bare)  # as docs/controllers.md says
    assert sum(figures.slips for figures in compensated) == 0
    assert max(figures.max_error for figures in compensated) < 1.2e-3
    assert max(f.rms_error for f in compensated) < 0.3 * max(f.rms_error for f in bare)


@pytest.mark.parametrize('compensated', [False, pytest.param(True, marks=pytest.mark.long)])
def test_the_limit_cycle_lasts_unless_it_is_compensated(compensated: bool) -> None:
    """With the command in docs/controllers.md; the first 30 s are those of the way there."""
    rig = Rig(load_configuration('cylinder_3'))
    reference = np.full(round(60.0 / rig.interval), SETPOINT)
    position = closed_loop(rig, LOW_GAINS, reference, compensated)
    half = slice(round(30.0 / rig.interval), None)
    figures = tracking(reference[half], position[half], rig.interval)
    if compensated:
        assert figures.slips == 0
        assert figures.wander < 1e-3
    else:
        assert figures.slips >= 2
        assert 3e-3 < figures.wander < 4.5e-3


def test_inertia_of_the_fluid_asks_for_a_rate_fed_back() -> None:
    """
    With T = 0.34 s it acts like a hundred times the mass of cylinder 2.

    Then sigma_2 alone damps it too little, and so does the rate that is enough for the cylinder
    as it is shipped, T = 0.022 s.
    """
    loops = (Pid(), Pid(derivative_gain=100.0))
    swinging, damped = (
        settled(controlled('cylinder_2', gains, 'reference_steps', fluid_time_constant=0.34))
        for gains in loops
    )
    assert max(figures.wander for figures in swinging) > 6e-3
    assert max(figures.wander for figures in damped) < 1e-3


@pytest.mark.parametrize('law', [Pid(), SlidingMode()], ids=['pid', 'sliding_mode'])
@pytest.mark.parametrize('cylinder', CYLINDERS)
def test_both_laws_come_to_rest_within_their_tolerance(cylinder: str, law: Law) -> None:
    figures = settled(controlled(cylinder, law, 'reference_steps'))
    assert max(part.rms_error for part in figures) < 5e-4
    assert sum(part.slips for part in figures) == 0


@pytest.mark.parametrize('law', [Pid(), SlidingMode()], ids=['pid', 'sliding_mode'])
@pytest.mark.parametrize(
    'cylinder',
    [
        pytest.param(name, marks=[] if name == 'cylinder_2' else [pytest.mark.long])
        for name in CYLINDERS
    ],
)
def test_both_laws_follow_a_ramp(cylinder: str, law: Law) -> None:
    interval, reference, position = controlled(cylinder, law, 'reference_ramp')
    moving = slice(round(2.0 / interval), None)
    assert tracking(reference[moving], position[moving], interval).rms_error < 2e-3


def test_outside_the_boundary_layer_nothing_is_integrated() -> None:
    law = SlidingMode()
    assert law.command(0.1, 0.0, 0.0, 0.0) == (law.switching_gain, 0.0)
    near, growth = law.command(1e-3, 0.0, 0.0, 0.0)
    assert growth == 1e-3
    assert 0.0 < near < law.command(1e-3, 0.0, 0.0, 1e-3)[0]


def test_an_error_within_the_tolerance_empties_the_integral() -> None:
    controller = PositionController(SlidingMode(), Compensation())
    near = controller.update(0.0, 0.101, 0.1, 0.0)
    controller.update(1.0, 0.101, 0.1, 0.0)
    assert controller.update(1.0, 0.101, 0.1, 0.0) > near
    assert controller.update(1.0, 0.101, 0.101, 0.0) == 0.0
    assert controller.update(1.0, 0.101, 0.1, 0.0) == near


def test_a_saturated_command_does_not_wind_the_integral_up() -> None:
    controller = PositionController(Pid(), NONE, limit=1.0)
    for _ in range(5000):
        assert controller.update(1e-3, 0.3, 0.0, 0.0) == 1.0
    assert controller.update(1e-3, 0.3, 0.31, 0.0) < 0.0


def test_a_jump_of_the_reference_is_no_speed() -> None:
    controller = PositionController(SlidingMode(), NONE)
    controller.update(1e-3, 0.1, 0.1, 0.0)
    after = controller.update(1e-3, 0.1005, 0.1, 0.0)
    jumped = controller.update(1e-3, 0.2005, 0.2, 0.0)
    assert after > jumped > 0.0


def test_tracking_counts_departures_from_rest() -> None:
    interval, time = 1e-3, np.arange(0.0, 6.0, 1e-3)
    position = 0.004 * (time // 2.0 + np.clip(5.0 * (time % 2.0 - 1.0), 0.0, 1.0))
    figures = tracking(np.zeros_like(time), position, interval)
    assert figures.slips == 3
    assert figures.wander == figures.max_error == pytest.approx(0.012)
