"""Forms of the second list: each law against its closed form, and runs that stay finite."""

import math

import numpy as np
import pytest

from . import constants as at
from . import foreign_gas, second_force, second_gas
from .foreign_force import JOINT_DAMPING
from .foreign_gas import CENTRE, wetted_area
from .motion import levels
from .plant import Plant
from .second import SECOND
from .second_sensors import misread
from .settings import settings
from .test_foreign import CYLINDER, INTERVAL, SAMPLES, hidden, motion, plant

PLANT = tuple(name for name, form in SECOND.items() if form.slot)


def state(rig: Plant, **changes: float) -> np.ndarray:
    """Return one state of the motion, with some of its numbers changed."""
    y = motion(rig)[60]
    for name, value in changes.items():
        y[getattr(at, name)] = value
    return y


def blank() -> np.ndarray:
    return np.zeros(at.SECOND_STATES)


def numbers_of(rig: Plant, slot: str) -> tuple[float, float, float]:
    """Return the strength of a form and two numbers of its shape."""
    place = at.FOREIGN + at.WIDTH * at.SLOTS.index(slot)
    strength, first, second = rig.e[place + 1 : place + 4].tolist()
    return strength, first, second


@pytest.mark.parametrize('name', PLANT)
def test_run_stays_finite_and_the_rig_moves(name: str) -> None:
    rig = plant(name, 1.0)
    moved = rig.run(np.repeat([[5.0, 0.0], [0.0, 5.0]], SAMPLES, axis=0), INTERVAL)
    assert moved.states.shape[1] == at.SECOND_STATES
    assert np.all(np.isfinite(moved.states))
    assert np.ptp(moved.position) > 1e-4


def test_plant_of_the_first_list_has_the_states_that_it_had() -> None:
    assert len(plant('woschni_heat', 1.0).y) == at.FOREIGN_STATES
    assert len(Plant(settings(CYLINDER)).y) == at.STATES


def test_inflow_stirs_the_gas_that_then_calms_down() -> None:
    rig, dy, volume = plant('inflow_heat', 1.0), blank(), 2e-4
    strength, time, _ = numbers_of(rig, 'heat')
    y = state(rig, STIRRED_1=2.0)
    gas = y[at.P1] * volume / (y[at.M1] * rig.c[at.R])
    heat = second_gas.heat(y, dy, 0, volume, 3e-5, rig.c, rig.e)
    area = wetted_area(volume, rig.c[at.A1])
    assert heat == pytest.approx(strength * area * 2.0**0.67 * (rig.c[at.T_S] - gas))
    assert dy[at.STIRRED_1] == pytest.approx((3.0 - 2.0) / time)
    second_gas.heat(y, dy, 0, volume, -3e-5, rig.c, rig.e)
    assert dy[at.STIRRED_1] == pytest.approx(-2.0 / time)


def test_regulator_droops_to_its_strength() -> None:
    e = plant('cracking_regulator', 1.0).e
    strength, flow = e[at.AT_SUPPLY + 1], e[at.AT_SUPPLY + 2]
    assert second_gas.droops(e)
    assert second_gas.droop(flow, e) == pytest.approx(0.5 * strength)
    assert second_gas.droop(1e3 * flow, e) == pytest.approx(strength, rel=2e-3)


def test_quadratic_droop_is_still_one() -> None:
    e = plant('quadratic_droop', 1.0).e
    assert second_gas.droop(2e-5, e) == pytest.approx(e[at.AT_SUPPLY + 1] * 4e-10)


@pytest.mark.parametrize(('share', 'open_share'), [(0.0, 0.0), (0.5, 0.5), (1.0, 1.0)])
def test_round_port_is_a_segment_of_a_circle(share: float, open_share: float) -> None:
    assert second_gas.segment(share) == pytest.approx(open_share)
    quarter = (math.acos(0.5) - 0.5 * math.sqrt(0.75)) / math.pi
    assert second_gas.segment(0.25) == pytest.approx(quarter)


def test_slit_is_pressed_shut() -> None:
    rig = plant('pressed_slit_leak', 1.0)
    strength, pressure, _ = numbers_of(rig, 'leak')
    p = rig.c[at.P_ATM] + pressure
    flow = second_gas.leak(state(rig), p, rig.c, rig.e)
    assert flow == pytest.approx(strength * (p**2 - 1e10) / 8.0)


def test_lip_leaks_from_the_first_chamber_alone() -> None:
    rig = plant('one_way_lip_leak', 1.0)
    strength, *_ = numbers_of(rig, 'cross_leak')
    forth, back = state(rig, P1=4e5, P2=2e5), state(rig, P1=2e5, P2=4e5)
    assert second_gas.cross_leak(forth, rig.c, rig.e) == pytest.approx(strength * 12e10)
    assert second_gas.cross_leak(back, rig.c, rig.e) == 0.0


def test_notch_is_shut_beyond_its_reach() -> None:
    rig = plant('notched_land_leak', 1.0)
    c, (strength, reach, exhaust) = rig.c, numbers_of(rig, 'null_leak')
    half = 0.5 * (c[at.U_M] - c[at.U_N])
    spool = c[at.U_M] + reach * half  # its exhaust edge is further covered than the notch is long
    into = foreign_gas.iso_flow(6e5, 3e5, second_gas.LAND_CRITICAL, c)
    assert second_gas.null_flow(6e5, spool, 3e5, c, rig.e) == pytest.approx(strength * into)
    spool = c[at.U_N] - reach * half
    out = exhaust * foreign_gas.iso_flow(3e5, c[at.P_ATM], second_gas.LAND_CRITICAL, c)
    assert second_gas.null_flow(6e5, spool, 3e5, c, rig.e) == pytest.approx(-strength * out)


def test_spool_lags_hunts_and_loses_travel() -> None:
    y, dy = state(plant('eddy_current_spool', 1.0), SPOOL_1=2.6, CLOCK=0.03, COIL_1=0.2), blank()
    e = plant('eddy_current_spool', 1.0).e
    share, time = e[at.AT_SPOOL + 1], e[at.AT_SPOOL + 2]
    assert second_gas.spool_of(y, dy, 0, 3.0, e) == pytest.approx(3.0 - 0.4 * share)
    assert dy[at.SPOOL_1] == pytest.approx(0.4 / time)
    e = plant('hunting_spool', 1.0).e
    swing = e[at.AT_SPOOL + 1] * math.sin(2.0 * math.pi * 0.03 * e[at.AT_SPOOL + 2])
    assert second_gas.spool_of(y, dy, 0, 3.0, e) == pytest.approx(3.0 + swing)
    e = plant('warming_coil', 1.0).e
    lost = 0.2 * e[at.AT_SPOOL + 1] * (3.0 - CENTRE)
    assert second_gas.spool_of(y, dy, 0, 3.0, e) == pytest.approx(3.0 - lost)
    assert dy[at.COIL_1] == pytest.approx((0.25 - 0.2) / e[at.AT_SPOOL + 2])


@pytest.mark.parametrize(
    ('loop', 'step', 'then'),
    [(0.0, 0.5, math.tanh(0.5)), (0.6, -0.2, 0.4), (0.6, -1.0, -math.tanh(0.4))],
)
def test_bouc_wen_loop_is_straight_when_it_is_unloaded(
    loop: float, step: float, then: float
) -> None:
    assert second_gas.loaded(loop, step) == pytest.approx(then)
    assert second_gas.loaded(second_gas.loaded(0.3, 0.2), 0.4) == pytest.approx(
        second_gas.loaded(0.3, 0.6)
    )


def test_line_is_that_of_poiseuille_or_of_blasius() -> None:
    c, bore, length = plant('darcy_line', 1.0).c, 3e-3, 0.5
    rt = c[at.R] * c[at.T_S]
    slow = second_gas.darcy_flow(1e6, bore, length, c)
    assert slow == pytest.approx(math.pi * bore**4 * 1e6 / (256.0 * 1.82e-5 * length * rt))
    fast = second_gas.darcy_flow(1e11, bore, length, c)
    area = 0.25 * math.pi * bore**2
    reynolds = fast * bore / (area * 1.82e-5)
    friction = 0.3164 * reynolds**-0.25
    squares = friction * length / bore * (fast / area) ** 2 * rt
    assert squares == pytest.approx(1e11)
    assert second_gas.darcy_flow(-1e11, bore, length, c) == -fast


def test_line_keeps_the_mass() -> None:
    rig, dy = plant('darcy_line', 1.0), blank()
    length, bore, _ = numbers_of(rig, 'line')
    y, c = state(rig), rig.c
    out = second_gas.through_line(y, dy, 0, 2e-5, c, rig.e)
    volume = 0.25 * math.pi * bore**2 * length
    stored = dy[at.PIPE_1] * volume / (c[at.KAPPA] * c[at.R] * c[at.T_S])
    assert stored == pytest.approx(2e-5 - out)
    assert second_gas.at_valve(y, 0, rig.e) == y[at.PIPE_1]


def test_side_volume_holds_what_the_chamber_gives() -> None:
    rig, dy = plant('side_volume', 1.0), blank()
    volume, time, _ = numbers_of(rig, 'gas_law')
    y = state(rig, P1=3e5, SIDE_1=2.9e5)
    flow = second_gas.side_flow(y, dy, 0, rig.c, rig.e)
    assert dy[at.SIDE_1] == pytest.approx(1e4 / time)
    assert flow == pytest.approx(volume * dy[at.SIDE_1] / (rig.c[at.R] * rig.c[at.T_S]))


def test_friction_of_rubber_saturates_with_pressure() -> None:
    rig = plant('thirion_seal', 1.0)
    strength, bars, _ = numbers_of(rig, 'pressure')
    y = state(rig, P1=rig.c[at.P_ATM] + 1e5 * bars, P2=rig.c[at.P_ATM])
    assert second_force.over_pressure(y, rig.c, rig.e) == pytest.approx(0.5 * strength * bars)


def test_load_across_the_rod_has_a_lever() -> None:
    rig = plant('side_loaded_rod', 1.0)
    strength, bearing, _ = numbers_of(rig, 'position')
    middle, out = (state(rig, X=share * rig.c[at.STROKE]) for share in (0.5, 1.0))
    assert second_force.over_place(out, rig.c, rig.e) == pytest.approx(strength / bearing)
    expected = strength * 0.5 / (0.5 + bearing)
    assert second_force.over_place(middle, rig.c, rig.e) == pytest.approx(expected)


def test_friction_warms_up_and_cools() -> None:
    rig, dy = plant('warming_and_cooling', 1.0), blank()
    strength, work, time = numbers_of(rig, 'warming')
    y = state(rig, V=0.1, HEATED=0.4)
    assert second_force.over_history(y, rig.e) == pytest.approx(math.exp(-0.4 * strength) - 1.0)
    second_force.history_rates(y, dy, 10.0, rig.e)
    assert dy[at.HEATED] == pytest.approx(1.0 / work - 0.4 / time)
    y[at.V] = 0.0
    second_force.history_rates(y, dy, 10.0, rig.e)
    assert dy[at.HEATED] == pytest.approx(-0.4 / time)


@pytest.mark.parametrize('name', ['thirion_seal', 'side_loaded_rod', 'warming_and_cooling'])
def test_both_levels_of_friction_have_what_is_added(name: str) -> None:
    given, present = plant(name, 1.0), plant(name, 0.0)
    y = state(given)
    more, less = (levels(y, 0.0, rig.memory, rig.c, rig.e) for rig in (given, present))
    sign = -1.0 if name == 'warming_and_cooling' else 1.0
    assert sign * (more[0] - less[0]) > 0.0
    assert sign * (more[1] - less[1]) > 0.0


def test_film_of_the_rod_seal_grows_as_the_root_of_speed() -> None:
    rig = plant('root_of_speed_outward', 1.0)
    strength, *_ = numbers_of(rig, 'side')
    out, back = state(rig, V=0.4), state(rig, V=-0.4)
    assert second_force.viscous(out, rig.c, rig.e) == pytest.approx(2.0 * strength, rel=1e-3)
    assert second_force.viscous(back, rig.c, rig.e) == 0.0


def test_eddy_current_brake_is_strongest_at_its_speed() -> None:
    rig = plant('eddy_current_brake', 1.0)
    strength, speed, _ = numbers_of(rig, 'viscous')
    pulls = [
        second_force.viscous(state(rig, V=share * speed), rig.c, rig.e)
        for share in (0.5, 1.0, 2.0)
    ]
    assert pulls[1] == pytest.approx(strength)
    assert pulls[0] == pytest.approx(pulls[2]) == pytest.approx(0.8 * strength)


def test_lip_relaxes_at_rest_and_slides_at_its_level() -> None:
    rig, dy = plant('relaxing_lip', 1.0), blank()
    strength, bend, time = numbers_of(rig, 'bristle')
    y = state(rig, V=0.0, ELEMENT_1=0.5)
    assert second_force.element_rates(y, dy, 4.0, rig.c, rig.e) == 0.5
    assert dy[at.ELEMENT_1] == pytest.approx(-0.5 / time)
    y[at.V], y[at.ELEMENT_1] = 0.1, 0.0
    second_force.element_rates(y, dy, 4.0, rig.c, rig.e)
    assert dy[at.ELEMENT_1] == pytest.approx(4.0 * strength / bend * 0.1)
    y[at.ELEMENT_1] = 4.0 * strength / (1.0 + bend / (0.1 * time))
    second_force.element_rates(y, dy, 4.0, rig.c, rig.e)
    assert dy[at.ELEMENT_1] == pytest.approx(0.0, abs=1e-9)


def test_stribeck_curve_is_a_tanh() -> None:
    rig = plant('tanh_curve', 1.0)
    strength, number, _ = numbers_of(rig, 'shape')
    found = second_force.stribeck_excess(rig.c[at.V_S] * number, rig.c, rig.e)
    assert found == pytest.approx(strength * (1.0 - math.tanh(1.0)))


def test_dwell_squeezes_a_film_out() -> None:
    e = plant('squeezed_out_dwell', 1.0).e
    strength, time = e[at.AT_DWELL + 1], e[at.AT_DWELL + 2]
    grown = 0.5 / (1.0 - (1.0 + 1000.0 / time) ** -0.5)
    share = second_force.dwell_share(3.0 * time, e)
    assert share == pytest.approx(1.0 - strength * (1.0 - grown))


def test_film_is_drawn_in_and_squeezed_out() -> None:
    rig = plant('entrained_film', 1.0)
    _, distance, time = numbers_of(rig, 'film')
    y = state(rig, V=-0.05, H=0.5)
    expected = 0.05 / distance * 0.5 - 0.125 / time
    assert second_force.film_rate(y, rig.c, rig.e) == pytest.approx(expected)


def test_cord_is_slack_at_the_inner_end() -> None:
    rig = plant('rubber_cord', 1.0)
    strength, stretch, _ = numbers_of(rig, 'load')
    slack, taut = state(rig, X=0.0), state(rig, X=rig.c[at.STROKE])
    assert second_force.load_force(slack, rig.c, rig.e) == 0.0
    pull = strength * (1.0 + stretch - (1.0 + stretch) ** -2)
    assert second_force.load_force(taut, rig.c, rig.e) == pytest.approx(-pull)


def test_magnet_holds_at_the_outer_end() -> None:
    rig = plant('holding_magnet', 1.0)
    strength, gap, _ = numbers_of(rig, 'load')
    near, away = state(rig, X=rig.c[at.STROKE]), state(rig, X=rig.c[at.STROKE] - gap)
    assert second_force.load_force(near, rig.c, rig.e) == pytest.approx(strength)
    assert second_force.load_force(away, rig.c, rig.e) == pytest.approx(0.25 * strength)


def test_pocket_is_pressed_and_empties_through_its_needle() -> None:
    rig, dy = plant('needle_cushion', 1.0), blank()
    strength, length, time = numbers_of(rig, 'pad')
    y = state(rig, X=0.5 * length, V=-0.2, POCKET_1=0.5, POCKET_2=0.0)
    assert second_force.pads(y, rig.c, rig.e) == pytest.approx(0.5 * strength)
    second_force.pocket_rates(y, dy, rig.c, rig.e)
    pressed = rig.c[at.KAPPA] * 1.5 * 0.2 / (0.8 * length)
    assert dy[at.POCKET_1] == pytest.approx(pressed - 0.5 / time)
    y[[at.V, at.POCKET_1]] = 0.0, -0.1
    second_force.pocket_rates(y, dy, rig.c, rig.e)
    assert dy[at.POCKET_1] == pytest.approx(0.1 / second_force.CHECK_TIME)
    assert second_force.pads(y, rig.c, rig.e) == 0.0
    y[at.X] = 0.5 * rig.c[at.STROKE]
    assert second_force.pads(y, rig.c, rig.e) == 0.0


def test_joint_has_dry_friction_beside_its_spring() -> None:
    rig = plant('dry_joint', 1.0)
    compliance, friction, _ = numbers_of(rig, 'joint')
    y = state(rig, STRETCH=1e-4, V=0.0, LOAD_V=0.0)
    assert second_force.joint(y, rig.e) == pytest.approx(1e-4 / compliance)
    y[at.LOAD_V] = 0.05
    expected = 1e-4 / compliance + friction + JOINT_DAMPING * 0.05
    assert second_force.joint(y, rig.e) == pytest.approx(expected)


def sensed(name: str, signal: np.ndarray) -> np.ndarray:
    """Return the positions that a sensor with a form shows."""
    pressures = np.full_like(signal, 2e5)
    return misread(np.stack([signal, pressures, pressures]), 1e-3, hidden(name, 1.0))[0]


def test_potentiometer_is_loaded_between_its_ends() -> None:
    strength = hidden('loaded_potentiometer', 1.0)['loaded_potentiometer.strength']
    shown = sensed('loaded_potentiometer', np.array([0.0, 0.15, 0.3]))
    assert shown == pytest.approx([0.0, 0.15 / (1.0 + 0.25 * strength), 0.3])


def test_average_of_a_ramp_is_half_its_span_behind() -> None:
    span = hidden('averaged_position', 1.0)['averaged_position.strength']
    time = 1e-3 * np.arange(200)
    shown = sensed('averaged_position', 0.05 * time)
    assert shown[100:] == pytest.approx(0.05 * (time[100:] - 0.5 * span))
    assert shown[0] == 0.0


def test_interpolation_errs_within_a_period() -> None:
    given = hidden('interpolated_position', 1.0)
    strength, period = (given[f'interpolated_position.{key}'] for key in ('strength', 'period'))
    shown = sensed('interpolated_position', period * np.array([2.0, 2.25, 2.5]))
    assert shown == pytest.approx(period * np.array([2.0, 2.25, 2.5]) + [0.0, strength, 0.0])
    assert 2.0 * math.pi * strength < SECOND['interpolated_position'].shape['period'][0]
