"""Foreign forms: absent at strength zero, there beyond it, and as physics wants them."""

import numpy as np
import pytest

from . import constants as at
from . import foreign, foreign_force, foreign_gas, second, second_force, second_gas
from . import foreign_sensors as sensors
from . import second_sensors as more_sensors
from .contributions import Seen, force, gas, seen
from .foreign import FORMS, KNOWN, UNKNOWN, Form
from .foreign_strengths import STRENGTHS
from .forms import ALL, ALL_STRENGTHS, NUMBERS, mechanism, numbers
from .plant import Plant, rates
from .runs import equations
from .second import SECOND, SECOND_KNOWN, SECOND_UNKNOWN
from .second_sensors import misread
from .second_strengths import SECOND_STRENGTHS
from .settings import Settings, changed, settings

CYLINDER = 'cylinder_2'
PLANT = tuple(name for name, form in ALL.items() if form.slot)
SAMPLES, INTERVAL = 400, 1e-3
EVERY_RATE = pytest.mark.parametrize('name', [name for name in PLANT if name != 'creeping_stop'])
"""But for what acts where the piston is held, and contributes to no rate."""


def of(*slots: str) -> list[str]:
    """Return the forms in some slots; '' is that of sensors."""
    return [name for name in ALL if ALL[name].slot in slots]


def hidden(name: str, strength: float) -> dict[str, float]:
    """Return a form at the middle of its shape; its strength a share of the strong one."""
    form = ALL[name]
    shape = {f'{name}.{key}': 0.5 * sum(bounds) for key, bounds in form.shape.items()}
    return {f'{name}.strength': strength * ALL_STRENGTHS[name][1][1], **shape}


def given(name: str) -> Settings:
    """Return the settings under which a form is there, with its friction law."""
    law = ALL[name].base
    return changed(settings(CYLINDER), {'friction.model': law} if law else {})


def plant(name: str, strength: float) -> Plant:
    return Plant(given(name), hidden(name, strength))


def without(name: str) -> Plant:
    return Plant(given(name))


def motion(plant: Plant) -> np.ndarray:
    """Return states that sweep stroke, speeds, pressures and all that forms remember."""
    c, t = plant.c, INTERVAL * np.arange(SAMPLES)
    y = np.zeros((SAMPLES, at.SECOND_STATES))
    turn = 2.0 * np.pi * t / t[-1]
    y[:, at.X] = c[at.STROKE] * (0.5 - 0.5 * np.cos(turn))
    y[:, at.V] = np.gradient(y[:, at.X], INTERVAL)
    y[:, at.P1] = 2.5e5 + 1e5 * np.sin(3.0 * turn)
    y[:, at.P2] = 2.8e5 + 1.2e5 * np.cos(2.0 * turn)
    volumes = c[at.V10] + c[at.A1] * y[:, at.X], c[at.V20] + c[at.A2] * (c[at.STROKE] - y[:, at.X])
    for chamber, volume in enumerate(volumes):
        y[:, at.M1 + chamber] = y[:, at.P1 + chamber] * volume / (c[at.R] * 310.0)
        y[:, at.PIPE_1 + chamber] = y[:, at.P1 + chamber] + 3e3 * np.cos(turn)
        y[:, at.SPOOL_1 + chamber] = 2.5 + 0.4 * np.sin(turn)
    y[:, [at.LINE_1, at.LINE_2]] = 1e-5
    y[:, at.Z] = 1e-4 * np.sin(2.0 * turn)
    y[:, at.H], y[:, at.CLOCK], y[:, at.WAY] = 0.5, 1.0 + t, 0.1
    y[:, [at.WALL_1, at.WALL_2]], y[:, at.SOURCE] = 305.0, 0.95 * c[at.P_S]
    y[:, [at.ELEMENT_1, at.ELEMENT_2, at.ELEMENT_3]] = 0.3
    y[:, at.LATE], y[:, at.SWING] = 0.7 * y[:, at.V], 1e-3
    y[:, [at.STRETCH, at.LOAD_V]] = 2e-3, 0.01
    y[:, [at.STIRRED_1, at.STIRRED_2, at.COIL_1, at.COIL_2]] = 0.8
    y[:, [at.SIDE_1, at.SIDE_2]] = y[:, [at.P1, at.P2]] - 5e3
    y[:, [at.HEATED, at.POCKET_1, at.POCKET_2]] = 0.5
    return y


def slopes(plant: Plant, spool: float) -> np.ndarray:
    """Return the rates of the states that all plants have, along the motion, shape (n, STATES)."""
    states, found = motion(plant), []
    for k, y in enumerate(states):
        own = y[: len(plant.y)].copy()
        plant.memory[at.STICKING] = float(k % 2)
        plant.memory[[at.TARGET_1, at.TARGET_2]] = spool, 5.0 - spool
        dy = np.zeros(len(own))
        rates(0.001 * k, own, dy, plant.memory, plant.c, plant.e, plant.stiffness, plant.limit)
        found.append(dy[: at.STATES])
    return np.array(found)


def voltages() -> np.ndarray:
    """Return voltages of both valves that go to and fro, shape (n, 2)."""
    one = np.concatenate([2.5 + 0.5 * np.sin(np.arange(300) / 20.0), np.full(100, 2.5)])
    return np.stack([one, 5.0 - one], axis=1)


def test_forms_are_many_and_each_is_told_of() -> None:
    assert len(FORMS) >= 60
    assert len({FORMS[name].mechanism for name in KNOWN}) >= 25
    assert len(UNKNOWN) >= 10
    used = codes(FORMS)
    assert {slot for slot, _ in used} == set(at.SLOTS)
    assert tuple(foreign.SENSOR) == sensors.NAMES
    assert set(STRENGTHS) == set(FORMS)


def codes(forms: dict[str, Form]) -> list[tuple[str, int]]:
    """Return where each of the forms of the plant is, and its code."""
    return [(form.slot, form.code) for form in forms.values() if form.slot]


def test_second_list_has_forms_of_its_own() -> None:
    assert (len(SECOND_KNOWN), len(SECOND_UNKNOWN)) == (22, 6)
    assert len({SECOND[name].mechanism for name in SECOND_KNOWN}) >= 18
    assert not set(SECOND) & set(FORMS)
    assert not set(codes(SECOND)) & set(codes(FORMS))
    assert all(code > at.SECOND_CODE for _, code in codes(SECOND))
    assert all(code <= at.SECOND_CODE for _, code in codes(FORMS))
    assert tuple(second.SENSOR) == more_sensors.NAMES
    assert set(SECOND_STRENGTHS) == set(SECOND)


def test_forms_have_a_source_and_a_place_of_their_own() -> None:
    assert all(form.reference for form in ALL.values())
    used = codes(ALL)
    assert len(set(used)) == len(used)


@pytest.mark.parametrize('name', ALL)
def test_strengths_and_shapes_are_ranges(name: str) -> None:
    form = ALL[name]
    assert len(ALL_STRENGTHS[name]) == 3
    assert all(0.0 < low < high for low, high in (*ALL_STRENGTHS[name], *form.shape.values()))
    assert len(form.shape) <= 2
    assert mechanism(name) == form.mechanism


def test_two_forms_in_one_place_are_refused() -> None:
    with pytest.raises(AssertionError, match='in one place'):
        numbers({**hidden('woschni_heat', 1.0), **hidden('thin_wall_heat', 1.0)})


@pytest.mark.parametrize('name', PLANT)
@pytest.mark.parametrize('spool', [2.9, 2.2])
def test_without_strength_the_plant_is_the_present_one(name: str, spool: float) -> None:
    given, present = slopes(plant(name, 0.0), spool), slopes(without(name), spool)
    if ALL[name].slot == 'film':  # it has a film of its own, which then does nothing
        given[:, at.H] = present[:, at.H]
    scale = np.max(np.abs(present), axis=0)
    assert np.all(np.abs(given - present) <= 1e-11 * scale)
    assert np.array_equal(second_gas.targets(voltages(), INTERVAL, plant(name, 0.0).e), voltages())


@EVERY_RATE
def test_with_strength_it_differs(name: str) -> None:
    strange = plant(name, 1.0)
    driven = second_gas.targets(voltages(), INTERVAL, strange.e)
    differs = [
        np.abs(slopes(strange, spool) - slopes(without(name), spool)).max() for spool in (2.9, 2.2)
    ]
    assert max(differs) > 0.0 or not np.array_equal(driven, voltages())


@EVERY_RATE
def test_contribution_is_on_the_balance_of_the_form(name: str) -> None:
    true, model = (equations(given(name), what) for what in (hidden(name, 1.0), {}))
    states = motion(plant(name, 1.0))
    shown = Seen(states, np.gradient(states[:, at.V], INTERVAL))
    driven = np.resize(voltages(), (SAMPLES, 2))
    targets = second_gas.targets(driven, INTERVAL, true.e)
    flows = gas(states, shown, targets, driven, true, model)
    rests = np.zeros(SAMPLES, dtype=bool)
    push = force(states, shown, rests, 10.0, INTERVAL, true, model)
    sizes = np.abs(flows).max() / 1e-5, np.abs(push).max()
    own, other = sizes if ALL[name].balance == 'gas' else sizes[::-1]
    assert own > 1e-3
    assert other < 1e-9


@pytest.mark.parametrize('name', of('heat'))
def test_heat_flows_from_hot_to_cold_and_none_is_lost(name: str) -> None:
    rig = plant(name, 1.0)
    y, dy, volume = motion(rig)[50], np.zeros(at.SECOND_STATES), 2e-4
    area = foreign_gas.wetted_area(volume, rig.c[at.A1])
    flows = []
    for gas_temperature in (270.0, 300.0, 330.0):
        y[at.M1] = y[at.P1] * volume / (rig.c[at.R] * gas_temperature)
        y[at.WALL_1] = 300.0
        flows.append(second_gas.heat(y, dy, 0, volume, 1e-5, rig.c, rig.e))
    assert flows[0] > 0.0 > flows[2]
    assert flows[1] == pytest.approx(0.0, abs=1e-9)
    if name == 'thin_wall_heat':  # what the gas gets, the wall gives
        stored = rig.e[at.AT_HEAT + 2] * area * dy[at.WALL_1]
        assert stored == pytest.approx(-flows[2])


@pytest.mark.parametrize('name', of('cross_leak'))
def test_cross_leak_keeps_the_mass_and_goes_downhill(name: str) -> None:
    given, present = plant(name, 1.0), without(name)
    more = slopes(given, 2.5) - slopes(present, 2.5)
    assert more[:, at.M1] == pytest.approx(-more[:, at.M2], rel=1e-9, abs=1e-18)
    states = motion(given)
    downhill = states[:, at.P2] - states[:, at.P1]
    assert np.all(more[:, at.M1] * downhill >= 0.0)


@pytest.mark.parametrize('name', of('leak'))
def test_leak_grows_with_the_pressure_and_vanishes_without(name: str) -> None:
    rig = plant(name, 1.0)
    y = motion(rig)[50]
    flows = [second_gas.leak(y, p, rig.c, rig.e) for p in (1e5, 2e5, 4e5, 6e5)]
    assert flows[0] == 0.0
    assert np.all(np.diff(flows) >= 0.0)
    assert flows[3] > 0.0


def test_iso_flow_is_choked_below_the_critical_ratio() -> None:
    c = Plant(settings(CYLINDER)).c
    assert foreign_gas.iso_flow(6e5, 1e5, 0.3, c) == foreign_gas.iso_flow(6e5, 1.7e5, 0.3, c)
    normal = 6e5 * 1.185 * (293.15 / c[at.T_S]) ** 0.5
    assert foreign_gas.iso_flow(6e5, 1e5, 0.3, c) == pytest.approx(normal)
    assert foreign_gas.iso_flow(2e5, 2e5, 0.3, c) == 0.0


def test_laminar_gap_is_the_difference_of_squares() -> None:
    rig = plant('laminar_seal_leak', 1.0)
    leak = second_gas.leak(motion(rig)[50], 4e5, rig.c, rig.e)
    assert leak == pytest.approx(rig.e[at.AT_LEAK + 1] * (4e5**2 - 1e5**2))


@pytest.mark.parametrize('name', ['line_volume', 'line_resonance', 'delay_and_lag'])
def test_line_passes_on_what_it_takes_in_when_it_is_settled(name: str) -> None:
    rig = plant(name, 1.0)
    y, dy, flow = motion(rig)[50], np.zeros(at.FOREIGN_STATES), 2e-5
    y[at.LINE_1] = flow
    y[at.PIPE_1] = y[at.P1] + flow / (rig.e[at.AT_LINE + 2] or 1.0)
    assert foreign_gas.through_line(y, dy, 0, flow, rig.c, rig.e) == pytest.approx(flow, rel=1e-6)
    assert abs(dy[at.PIPE_1]) < 1.0
    assert abs(dy[at.LINE_1]) < 1e-6


@pytest.mark.parametrize('name', ['small_tank', 'slow_regulator'])
def test_supply_settles_where_feed_and_flow_agree(name: str) -> None:
    rig, flow = plant(name, 1.0), 1e-5
    y, strength, number = motion(rig)[50], *rig.e[at.AT_SUPPLY + 1 : at.AT_SUPPLY + 3]
    droop = flow / number if name == 'small_tank' else strength * flow
    y[at.SOURCE] = rig.c[at.P_S] - droop
    assert foreign_gas.source_rate(y, flow, rig.c, rig.e) == pytest.approx(0.0, abs=1.0)
    assert foreign_gas.source_rate(y, 2.0 * flow, rig.c, rig.e) < -1e2


@pytest.mark.parametrize('name', of('curve'))
def test_curve_is_shut_at_the_edge_and_never_falls(name: str) -> None:
    e = plant(name, 1.0).e
    for intake in (True, False):
        opening = [second_gas.bent(share, intake, e) for share in np.linspace(0.0, 1.0, 40)]
        assert opening[0] == 0.0
        assert np.all(np.diff(opening) >= 0.0)


@pytest.mark.parametrize('name', of('play'))
def test_spool_is_never_further_off_than_its_strength(name: str) -> None:
    e, wanted = plant(name, 1.0).e, voltages()
    found = second_gas.targets(wanted, INTERVAL, e)
    strength = e[at.AT_PLAY + 1]
    if name in ('valve_dead_time', 'delay_and_lag'):
        late = round(strength / INTERVAL)
        assert np.array_equal(found[late:], wanted[:-late])
    else:
        assert np.max(np.abs(found - wanted)) <= strength * (1.0 + 1e-12)
        again = second_gas.targets(np.concatenate([wanted, wanted]), INTERVAL, e)
        third = second_gas.targets(np.concatenate([wanted, wanted, wanted]), INTERVAL, e)
        near = 1e-6 if name == 'bouc_wen_spool' else 1e-9  # which settles into its loop
        assert third[-SAMPLES:] == pytest.approx(again[-SAMPLES:], abs=near)  # the loop closes


@pytest.mark.parametrize('name', of('viscous', 'side'))
def test_viscous_friction_dissipates(name: str) -> None:
    rig = plant(name, 0.9)
    for y in motion(rig):
        y[at.LATE] = y[at.V]
        force = second_force.viscous(y, rig.c, rig.e) + rig.c[at.SIGMA_2] * y[at.V]
        assert force * y[at.V] >= 0.0


@pytest.mark.parametrize('name', of('bristle'))
def test_bristles_bend_at_first_and_slide_in_the_end(name: str) -> None:
    e = plant(name, 0.9).e
    assert foreign_force.bending(0.0, e) == 1.0
    assert foreign_force.bending(1.0, e) == pytest.approx(0.0, abs=1e-12)
    shares = [foreign_force.bending(ratio, e) for ratio in np.linspace(-1.0, 1.5, 50)]
    assert np.all(np.diff(shares) <= 1e-12)


def test_elements_dissipate_over_a_cycle() -> None:
    rig = plant('maxwell_slip', 1.0)
    y, dy, step, work = np.zeros(at.FOREIGN_STATES), np.zeros(at.FOREIGN_STATES), 1e-5, 0.0
    for k in range(40_000):  # two cycles of 5 Hz, 2 mm
        y[at.V] = 0.002 * 2.0 * np.pi * 5.0 * np.cos(2.0 * np.pi * 5.0 * k * step)
        total = foreign_force.element_rates(y, dy, 4.0, rig.c, rig.e)
        places = slice(at.ELEMENT_1, at.ELEMENT_3 + 1)
        y[places] += step * dy[places]
        work += total * y[at.V] * step * (k >= 20_000)
    level = rig.e[at.AT_BRISTLE + 1] * 4.0
    assert 0.3 * level * 0.008 < work < level * 0.008


@pytest.mark.parametrize('name', of('dwell'))
def test_static_friction_grows_with_the_dwell_to_all_of_it(name: str) -> None:
    e = plant(name, 1.0).e
    shares = [second_force.dwell_share(dwell, e) for dwell in (0.0, 0.5, 4.0, 60.0, 1000.0, 3e3)]
    assert np.all(np.diff(shares) >= 0.0)
    assert shares[0] == pytest.approx(1.0 - e[at.AT_DWELL + 1])
    assert shares[-1] == shares[-2] == pytest.approx(1.0)


@pytest.mark.parametrize('name', of('shape'))
def test_stribeck_curve_falls_from_its_strength(name: str) -> None:
    rig = plant(name, 1.0)
    curve = [second_force.stribeck_excess(v, rig.c, rig.e) for v in np.linspace(0.0, 0.5, 30)]
    assert curve[0] == pytest.approx(rig.e[at.AT_SHAPE + 1])
    assert np.all(np.diff(curve) < 0.0)


def test_progressive_spring_is_cubic() -> None:
    rig = plant('progressive_spring', 1.0)
    y, c = motion(rig)[100], rig.c
    expected = -rig.e[at.AT_LOAD + 1] * y[at.X] ** 3 / c[at.STROKE] ** 2
    assert foreign_force.load_force(y, c, rig.e) == pytest.approx(expected)


@pytest.mark.parametrize('name', [name for name in of('pad') if name in FORMS])
def test_cushion_pushes_away_and_only_when_it_is_touched(name: str) -> None:
    e = plant(name, 1.0).e
    assert foreign_force.pad_force(-1e-3, 0.1, e) == 0.0
    pushes = [foreign_force.pad_force(depth, 0.1, e) for depth in (1e-3, 2e-3, 4e-3)]
    assert np.all(np.diff([0.0, *pushes]) > 0.0)


def test_play_of_a_joint_is_free_and_the_load_keeps_its_momentum() -> None:
    rig = plant('joint_with_play', 1.0)
    y, play = motion(rig)[50], rig.e[at.AT_JOINT + 2]
    y[at.STRETCH] = 0.4 * play
    assert foreign_force.foreign_joint(y, rig.e) == 0.0
    y[at.STRETCH] = 0.6 * play
    assert foreign_force.foreign_joint(y, rig.e) != 0.0


def test_outer_stop_creeps_inward_with_time() -> None:
    rig = plant('creeping_stop', 1.0)
    y = motion(rig)[0]
    y[at.CLOCK] = foreign_gas.RUN
    assert rig._outer_stop(y) == pytest.approx(rig.c[at.STROKE] - rig.e[at.AT_STOP + 1])
    assert plant('creeping_stop', 0.0)._outer_stop(y) == rig.c[at.STROKE]


@pytest.mark.parametrize('walk', [0.0, 3.7, 55.0])
def test_walks_start_at_zero_and_differ(walk: float) -> None:
    assert foreign_force.walk(0.0, walk) == 0.0
    assert foreign_force.walk(7.0, walk) != foreign_force.walk(7.0, walk + 1.0)


def signals() -> np.ndarray:
    t = np.linspace(0.0, 14.0, 2000)
    return np.stack([0.1 + 0.05 * np.sin(t), 3e5 + 1e5 * np.cos(t), 2e5 + 5e4 * np.sin(2.0 * t)])


@pytest.mark.parametrize('name', of(''))
def test_sensor_errs_by_its_strength_and_not_without(name: str) -> None:
    true = signals()
    assert np.array_equal(misread(true, 0.007, hidden(name, 0.0)), true)
    off = np.abs(misread(true, 0.007, hidden(name, 1.0)) - true).max(axis=1)
    position = 'pressure' not in name
    assert (off[0] > 1e-5) == position
    assert (max(off[1:]) > 100.0) != position
    states = np.zeros((2000, at.STATES))
    states[:, [at.X, at.P1, at.P2]] = true.T
    shown = seen(states, 0.007, hidden(name, 1.0))
    assert np.abs(shown.states - states).max() > 0.0


def test_bowed_sensor_is_right_at_both_ends() -> None:
    ends = np.array([[0.0, 0.3], [1e5, 1.1e6], [1e5, 1.1e6]])
    for name in ('bowed_position', 'bowed_pressure'):
        assert misread(ends, 0.001, hidden(name, 1.0)) == pytest.approx(ends)


def test_numbers_that_can_be_hidden_are_those_of_the_forms() -> None:
    assert all(set(hidden(name, 1.0)) <= NUMBERS for name in ALL)
