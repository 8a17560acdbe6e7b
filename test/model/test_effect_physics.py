"""Each effect against a closed form or a limiting case."""

import math
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from pneu_rig_ros.model import effects, valve
from pneu_rig_ros.model.compiled_model import (
    ChamberGas,
    Motion,
    Ports,
    Seal,
    Signals,
    compiled_model,
)
from pneu_rig_ros.model.effect import LEAST_TIME
from pneu_rig_ros.model.plant import Plant

from .rigs import SHUT, changed, drive, plant_with, stroke, with_effects

MODEL = changed('cylinder_2')
COMPILED = compiled_model(MODEL)
LAW, VALVE, GAS = COMPILED.friction, COMPILED.valve, COMPILED.gas
STROKE, SUPPLY = MODEL.cylinder.stroke, MODEL.operation.supply_pressure
AT_REST = Signals(
    time=0.0,
    motion=Motion(0.1, 0.0),
    gas=ChamberGas(2e5, 1.5e5, 1e-4, 2e-4, 2e-4, 3e-4),
    ports=Ports(2.5, 2.5, SUPPLY, SUPPLY),
    seal=Seal(0.0, 0.0, False, 0.0, LAW.coulomb_force, LAW.breakaway_force),
)


def at_rest(time: Any = 0.0, **changes: Any) -> Signals:
    """Return the signals at rest, some fields of their groups changed."""
    groups = [
        group._replace(**{key: changes.pop(key) for key in group._fields if key in changes})
        for group in AT_REST[1:]
    ]
    assert not changes
    return Signals(time, *groups)


def contribute(name: str, values: tuple[float, ...], state: Any = (), **signals: Any) -> Any:
    """Return the pair of contributions of an effect and the rates of its states."""
    effect = effects.load(name)
    rate = np.zeros(len(effect.states))
    given = np.array(state if len(state) else np.zeros(len(rate)), dtype=np.float64)
    states = (given, rate) if effect.takes_states else ()
    seen = at_rest(**signals)
    pair = effect.contribution(seen, COMPILED, effect.parameters(*values), *states)
    return *pair, rate


def settle(
    name: str,
    values: tuple[float, ...],
    duration: float,
    state: Any = (),
    **signals: Any,
) -> NDArray[np.float64]:
    """Return the states of an effect after holding its signals for the duration [s]."""
    start = np.array(state if len(state) else np.zeros(len(effects.load(name).states)))
    solution = solve_ivp(
        lambda _, y: contribute(name, values, y, **signals)[2],
        (0.0, duration),
        start,
        rtol=1e-9,
        atol=1e-12,
    )
    return cast(NDArray[np.float64], solution.y[:, -1])


def test_supply_droop_is_resistance_times_flow() -> None:
    resistance = 2e9
    opening = VALVE.intake_coefficient * (3.0 - VALVE.intake_voltage)
    conductance = GAS.choked_coefficient * GAS.flow_scale * opening  # choked: flow = C p_s
    expected = SUPPLY * resistance * conductance / (1.0 + resistance * conductance)
    lack, same, _ = contribute('supply_droop', (resistance,), voltage_1=3.0, voltage_2=2.0)
    assert lack == same == pytest.approx(-expected, rel=1e-8)
    assert 0.05 * SUPPLY < expected < 0.5 * SUPPLY
    assert contribute('supply_droop', (resistance,))[0] == 0.0


@pytest.mark.parametrize('pressure', [1e5, 3e5, 4e5, 4.99e5, 5e5, 6e5])
@pytest.mark.parametrize('resistance', [1e8, 2e9, 1e10])
@pytest.mark.parametrize('exponent', [0.3, 1.0, 2.0])
def test_supply_droop_solves_its_equation_at_any_pressure(
    pressure: float, resistance: float, exponent: float
) -> None:
    signals = {'voltage_1': 5.0, 'voltage_2': 0.0, 'pressure_1': pressure}
    droop = -contribute('supply_droop', (resistance, exponent), **signals)[0]

    def excess(lack: float) -> float:
        flow = max(valve.mass_flow(5.0, pressure, SUPPLY - lack, VALVE, GAS), 0.0)
        return lack - resistance * 1e-4 * (flow / 1e-4) ** exponent

    assert excess(droop - 1e-2) <= 0.0 <= excess(droop + 1e-2)  # where it is steep, too


def test_cross_piston_leak_keeps_the_gas_and_equalises_the_pressures() -> None:
    plant = plant_with(
        'cross_piston_leak',
        1e-6,
        operation={'initial_pressure_1': 1.05e5, 'initial_position': 0.1},
    )
    before = plant.state
    run = drive(plant, SHUT, 3.0)
    mass = run.gas_mass_1 + run.gas_mass_2
    assert mass == pytest.approx(before.gas_mass_1 + before.gas_mass_2, rel=1e-9)
    assert run.gas_mass_1[-1] < before.gas_mass_1
    assert run.pressure_1[-1] == pytest.approx(run.pressure_2[-1], abs=2.0)


def test_local_piston_leak_is_that_of_the_piston_in_a_bell_around_its_place() -> None:
    whole = contribute('cross_piston_leak', (1e-8,), pressure_1=4e5)[:2]
    for away, share in ((0.0, 1.0), (0.1, math.exp(-1.0)), (-0.2, math.exp(-4.0))):
        place = (0.6 + away) * STROKE
        values = (1e-8, 0.6, 0.1)
        local = contribute('local_piston_leak', values, pressure_1=4e5, position=place)[:2]
        assert local == pytest.approx([share * flow for flow in whole])


def test_valve_null_leak_halves_at_the_centre_and_fades_beyond() -> None:
    def leak(voltage: float) -> float:
        pair = contribute('valve_null_leak', (1e-9, 0.0), voltage_1=voltage)
        return cast(float, pair[0])

    edge = valve.port_flow(SUPPLY, AT_REST.gas.pressure_1, 1e-9, VALVE, GAS)
    assert leak(VALVE.intake_voltage) == pytest.approx(edge)
    assert leak(2.5) == pytest.approx(0.5 * edge)
    assert leak(0.0) < 0.06 * edge


def test_valve_null_leak_settles_where_intake_equals_exhaust() -> None:
    areas = (2e-9, 4e-9)  # choked intake, subsonic exhaust
    pressures = np.linspace(1.01e5, 4.9e5, 4000)
    flows = [contribute('valve_null_leak', areas, pressure_1=p)[0] for p in pressures]
    blocked = float(pressures[np.argmin(np.abs(flows))])
    exhaust = valve.port_flow(blocked, GAS.atmospheric_pressure, 2e-9, VALVE, GAS)
    intake = GAS.choked_coefficient * GAS.flow_scale * SUPPLY * 1e-9
    assert exhaust == pytest.approx(intake, rel=1e-3)
    assert np.all(np.diff(flows) <= 0.0)


def test_nonlinear_opening_is_a_power_of_the_way() -> None:
    full = 5.0 - VALVE.intake_voltage
    way = 0.25 * full
    bend, back, _ = contribute(
        'nonlinear_opening',
        (2.0, 3.0),
        voltage_1=VALVE.intake_voltage + way,
        voltage_2=0.5 * VALVE.exhaust_voltage,
    )
    assert way + bend == pytest.approx(full * 0.25**2)
    assert back == pytest.approx(VALVE.exhaust_voltage * (0.5 - 0.5**3))
    full_open = contribute('nonlinear_opening', (2.0, 3.0), voltage_1=5.0, voltage_2=0.0)
    assert full_open[:2] == (0.0, 0.0)
    assert contribute('nonlinear_opening', (0.5, 0.5))[:2] == (0.0, 0.0)


@pytest.mark.parametrize('curvature', [-0.4, 0.8])
def test_opening_with_a_curvature_is_a_parabola_whose_slope_at_the_edge_is_stated(
    curvature: float,
) -> None:
    full = 5.0 - VALVE.intake_voltage
    for share in (1e-4, 0.3, 1.0):
        bend, back, _ = contribute(
            'nonlinear_opening',
            (1.0, 1.0, curvature),
            voltage_1=VALVE.intake_voltage + share * full,
            voltage_2=(1.0 - share) * VALVE.exhaust_voltage,
        )
        assert bend == pytest.approx(full * curvature * share**2)
        assert back == pytest.approx(-VALVE.exhaust_voltage * curvature * share**2)


def test_no_opening_is_negative() -> None:
    voltage = VALVE.intake_voltage + 0.2 * (5.0 - VALVE.intake_voltage)
    bend = contribute('nonlinear_opening', (3.0, 3.0, -0.5), voltage_1=voltage)[0]
    assert voltage + bend == pytest.approx(VALVE.intake_voltage)


@pytest.mark.parametrize('exponent', [0.5, 1.0, 2.0])
def test_nonlinear_opening_keeps_the_exhaust_at_its_edge_and_fully_open(exponent: float) -> None:
    counted = VALVE._replace(exhaust_zero_voltage=VALVE.intake_voltage)

    def opening(voltage: float) -> float:
        """In volts, from the flow."""
        bend = contribute('nonlinear_opening', (2.0, exponent), voltage_1=voltage)[0]
        assert (bend == 0.0) == (exponent == 1.0 or voltage in (0.0, edge))
        out = -valve.mass_flow(voltage + bend, 3e5, SUPPLY, counted, GAS)
        unit = counted.exhaust_coefficient * GAS.choked_coefficient * 3e5 * GAS.flow_scale
        return out / unit

    edge = counted.exhaust_voltage
    jump = counted.exhaust_zero_voltage - edge
    assert opening(edge) == 0.0
    assert opening(edge - 1e-4) == pytest.approx(jump, abs=edge * (1e-4 / edge) ** exponent * 2.0)
    assert opening(0.75 * edge) == pytest.approx(jump + edge * 0.25**exponent)
    assert opening(0.0) == pytest.approx(counted.exhaust_zero_voltage)


@pytest.mark.parametrize(
    ('name', 'values'),
    [
        ('valve_lag', (0.05,)),
        ('spool_hysteresis', (0.1,)),
        ('nonlinear_opening', (1.5, 1.5)),
        ('valve_null_leak', (1e-9, 1e-9)),
        ('line_lag', (0.03,)),
        ('line_resistance', (3e8,)),
        ('spool_rate_limit', (0.05,)),
    ],
)
def test_spools_that_pass_the_jump_of_the_exhaust_cost_neither_accuracy_nor_steps(
    name: str, values: tuple[float, ...]
) -> None:
    def there_and_back(zero: float, tolerance: float) -> tuple[Plant, NDArray[np.float64]]:
        plant = plant_with(name, *values, valve={'exhaust_zero_voltage': zero})
        plant.tolerance = tolerance
        u = np.repeat([0.5, 0.0, -0.5], 500)
        run = plant.run(np.stack([2.5 + u, 2.5 - u], axis=1), 1e-3)
        return plant, np.stack([run.position / STROKE, run.velocity, run.pressure_2 / SUPPLY])

    continuous, without = there_and_back(VALVE.exhaust_voltage, 1e-6)
    jumps, rough = there_and_back(VALVE.intake_voltage, 1e-6)
    _, fine = there_and_back(VALVE.intake_voltage, 1e-8)
    assert np.abs(rough - fine).max() < 1e-4 < np.abs(rough - without).max()
    tried = [plant.counts['steps'] + plant.counts['rejected'] for plant in (continuous, jumps)]
    assert tried[1] < 2 * tried[0]


def test_spool_hysteresis_is_a_loop_of_its_width() -> None:
    width, spools, loop = 0.1, np.zeros(2), []
    for voltage in (3.0, 2.95, 2.5, 2.0, 2.05):
        signals = {'voltage_1': voltage, 'voltage_2': 2.5}
        spools = settle('spool_hysteresis', (width,), 0.05, spools, **signals)
        loop.append(2.5 + spools[0])
    assert loop == pytest.approx([2.95, 2.95, 2.55, 2.05, 2.05], abs=1e-6)
    assert spools[1] == 0.0


@pytest.mark.parametrize('name', ['valve_lag', 'line_lag'])
def test_lag_has_its_time_constant(name: str) -> None:
    signals = {'voltage_1': 3.0, 'voltage_2': 2.5}
    target = settle(name, (0.02,), 1.0, **signals)
    after = settle(name, (0.02,), 0.02, **signals)
    assert after[0] == pytest.approx((1.0 - math.exp(-1.0)) * target[0], rel=1e-6)
    if name == 'line_lag':
        flow = valve.mass_flow(3.0, AT_REST.gas.pressure_1, SUPPLY, VALVE, GAS)
        lack = contribute(name, (0.02,), **signals)[0]
        assert (lack, target[0]) == pytest.approx((-flow, flow / 1e-4))


@pytest.mark.parametrize('name', ['valve_lag', 'line_lag'])
def test_lag_that_is_too_short_to_be_followed_acts_in_proportion(name: str) -> None:
    signals, short = {'voltage_1': 3.0, 'voltage_2': 2.5}, 0.25 * LEAST_TIME
    at_once = contribute(name, (LEAST_TIME,), **signals)
    lack, _, rate = contribute(name, (short,), **signals)
    assert lack == pytest.approx(0.25 * at_once[0])
    assert rate == pytest.approx(at_once[2])
    # the integral of what is lacking is the time constant times the step, as it is for any lag
    decayed = settle(name, (short,), LEAST_TIME, **signals)
    assert contribute(name, (short,), decayed, **signals)[0] == pytest.approx(
        lack * math.exp(-1.0), rel=1e-6
    )


def test_part_of_a_step_passes_a_lag_of_the_spool_at_once() -> None:
    signals = {'voltage_1': 3.0, 'voltage_2': 2.5}
    whole = contribute('valve_lag', (0.05,), **signals)
    part = contribute('valve_lag', (0.05, 0.3), **signals)
    assert part[0] == pytest.approx(0.3 * whole[0])
    assert part[2] == pytest.approx(whole[2])


def test_line_lag_ends_with_the_gas_of_an_immediate_flow() -> None:
    at_rest = {'friction': {'breakaway_force': 1e4, 'coulomb_force': 1e4}}
    masses = []
    for time_constant in (0.0, 0.02):
        plant = plant_with('line_lag', time_constant, **at_rest)
        stroke(plant, 1.0, 0.5)
        masses.append(drive(plant, SHUT, 0.5).gas_mass_1[-1])
    assert masses[1] == pytest.approx(masses[0], rel=1e-5)


def test_friction_differs_by_direction() -> None:
    def level(
        velocity: float, bristles: float, sticking: bool, one_sidedness: float = 0.0
    ) -> tuple[float, float]:
        return cast(
            tuple[float, float],
            contribute(
                'direction_dependent_friction',
                (0.2, one_sidedness),
                velocity=velocity,
                bristle_force=bristles,
                sticking=sticking,
            )[:2],
        )

    more = (0.2 * LAW.coulomb_force, 0.2 * LAW.breakaway_force)
    less = tuple(-value for value in more)
    assert level(0.01, 1.0, False) == pytest.approx(more)
    assert level(-0.01, -1.0, False) == pytest.approx(less)
    assert level(0.0, LAW.breakaway_force, True) == pytest.approx(more)
    assert level(0.0, -LAW.breakaway_force, True) == pytest.approx(less)
    for side in (1.0, -1.0):  # both directions together differ by as much on one side alone
        assert level(0.01 * side, side, False, side) == pytest.approx(
            tuple(2.0 * side * value for value in more)
        )
        assert level(-0.01 * side, -side, False, side) == (0.0, 0.0)
    assert level(0.0, 0.0, True) == (0.0, 0.0)


def test_viscous_friction_differs_by_direction() -> None:
    def force(velocity: float, one_sidedness: float) -> float:
        values = (30.0, one_sidedness)
        pair = contribute('direction_dependent_viscous_friction', values, velocity=velocity)
        return cast(float, pair[0])

    assert force(0.1, 0.0) == force(-0.1, 0.0) == pytest.approx(-3.0)  # opposes, then helps
    assert force(0.1, 1.0) == pytest.approx(-6.0)
    assert force(-0.1, 1.0) == 0.0
    assert force(0.1, -1.0) == 0.0
    assert force(-0.1, -1.0) == pytest.approx(-6.0)


def test_friction_changes_linearly_along_the_stroke() -> None:
    levels = [
        contribute('position_dependent_friction', (0.4,), position=x)[1]
        for x in (0.0, 0.5 * STROKE, STROKE)
    ]
    assert levels == pytest.approx(np.array([-0.2, 0.0, 0.2]) * LAW.breakaway_force)


def test_friction_bulges_along_the_stroke_with_the_same_mean() -> None:
    places = np.linspace(0.0, STROKE, 101)
    levels = [contribute('position_dependent_friction', (0.0, 0.3), position=x)[1] for x in places]
    ends, middle = levels[0], levels[50]
    assert levels[-1] == pytest.approx(ends)
    assert middle - ends == pytest.approx(0.3 * LAW.breakaway_force)
    assert np.trapezoid(levels, places) == pytest.approx(0.0, abs=1e-3 * STROKE)


def test_friction_warms_up_with_the_work() -> None:
    velocity, force, work = 0.02, 3.0, 0.5
    power = force * velocity + LAW.viscous_coefficient * velocity**2
    values, signals = (0.3, work), {'velocity': velocity, 'bristle_force': force}
    warmth = settle('friction_warm_up', values, work / power, **signals)
    assert warmth[0] == pytest.approx(1.0 - math.exp(-1.0), rel=1e-6)
    level = contribute('friction_warm_up', values, warmth, **signals)[0]
    assert level == pytest.approx(-0.3 * warmth[0] * LAW.coulomb_force)
    assert contribute('friction_warm_up', values, warmth)[2] == 0.0  # nothing happens at rest


def test_spring_is_balanced_by_pressure() -> None:
    """At a frictionless rest the spring carries the force of the gas."""
    stiffness, compression = 2e3, 0.05
    plant = plant_with(
        'load_spring',
        stiffness,
        compression,
        friction={'model': 0, 'coulomb_force': 1e-3, 'breakaway_force': 1e-3},
    )
    stroke(plant, 0.6, 3.0)
    drive(plant, SHUT, 5.0)
    state, cylinder = plant.state, MODEL.cylinder
    gauge_1, gauge_2 = state.pressure_1 - 1e5, state.pressure_2 - 1e5
    gas = gauge_1 * cylinder.cap_area - gauge_2 * cylinder.rod_area
    assert 0.01 < state.position < 0.19
    assert abs(state.velocity) < 1e-5
    assert gas == pytest.approx(stiffness * (state.position + compression), rel=1e-4)


def test_spring_that_the_rod_has_not_met_does_not_push() -> None:
    forces = [contribute('load_spring', (2e3, -0.05), position=x)[0] for x in (0.0, 0.05, 0.06)]
    assert forces[:2] == [0.0, 0.0]
    assert forces[2] == pytest.approx(-20.0)


def test_cushion_never_pulls_and_gives_no_energy() -> None:
    values = (0.02, 1e4, 500.0)

    def force(depth: float, speed: float) -> float:
        pair = contribute('end_cushion', values, position=STROKE - 0.02 + depth, velocity=speed)
        return cast(float, -pair[0])

    assert force(-1e-3, 1.0) == 0.0
    for depth in (0.001, 0.01, 0.02):
        assert force(depth, 0.0) == pytest.approx(1e4 * depth)
        for speed in (0.01, 0.3, 3.0):
            assert force(depth, speed) > force(depth, 0.0) > force(depth, -speed) >= 0.0
    cap = contribute('end_cushion', values, position=0.005, velocity=-0.1)[0]
    assert cap == pytest.approx(force(0.015, 0.1))
    strengths = effects.load('end_cushion').proportional
    assert strengths == ('stiffness', 'damping')
    twice = effects.load('end_cushion').parameters(0.02, 2e4, 1e3)
    pressed = contribute('end_cushion', twice, position=STROKE - 0.01, velocity=0.3)[0]
    assert -pressed == pytest.approx(2.0 * force(0.01, 0.3))


def test_loose_load_swings_at_its_frequency_and_keeps_its_momentum() -> None:
    compliance, mass = 2e-5, MODEL.operation.load_mass
    omega = math.sqrt(1.0 / (compliance * mass))
    # held rod, load let go at one unit of stretch: half a period later it is at the other side,
    # but for what the joint takes in any case
    ratio = 0.01
    damped = omega * math.sqrt(1.0 - ratio**2)
    end = settle('load_compliance', (compliance, 0.0), math.pi / damped, (1.0, 0.0))
    left = math.exp(-ratio * omega * math.pi / damped)
    assert end == pytest.approx([-left, 0.0], abs=1e-6)
    force, added, rate = contribute('load_compliance', (compliance, 10.0), (1.0, 0.1))
    assert force == pytest.approx(1e-3 / compliance + 10.0 * 0.1)
    assert (added, mass * rate[1]) == pytest.approx((-mass, -force))


def test_stiff_joint_moves_the_load_like_a_rigid_one() -> None:
    rigid = stroke(plant_with('load_compliance', 0.0, 0.0), 0.34, 3.0)
    stiff = stroke(plant_with('load_compliance', 1e-6, 50.0), 0.34, 3.0)
    assert stiff.position == pytest.approx(rigid.position, abs=2e-4)
    assert np.ptp(rigid.position) > 0.01


def test_flow_effects_see_the_spool_not_the_command() -> None:
    chosen = with_effects(valve_lag=(1.0,), line_lag=(1e-3,))
    run = stroke(Plant(MODEL, chosen), 2.5, 0.05)  # the spool still stands in the overlap
    assert np.all(np.diff(run.gas_mass_1) == 0.0)


def test_opening_is_bent_where_the_lagging_spool_stands() -> None:
    """With the spool halfway to its voltage the flow is that of the bent opening there."""
    chosen = with_effects(valve_lag=(1.0,), nonlinear_opening=(2.0, 2.0))
    at_rest = {'friction': {'breakaway_force': 1e4, 'coulomb_force': 1e4}}
    run = stroke(Plant(changed('cylinder_2', **at_rest), chosen), 1.0, 0.7)
    spool = 2.5 + 1.0 - math.exp(-run.time[-1])
    full = 5.0 - VALVE.intake_voltage
    opening = VALVE.intake_coefficient * (spool - VALVE.intake_voltage) ** 2 / full
    flow = valve.port_flow(SUPPLY, run.pressure_1[-1], opening, VALVE, GAS)
    rate = np.gradient(run.gas_mass_1, run.time)[-2:].mean()
    assert rate == pytest.approx(flow, rel=5e-3)


def test_levels_together_leave_some_friction() -> None:
    chosen = with_effects(
        direction_dependent_friction=(-0.5,),
        position_dependent_friction=(1.0,),
        friction_warm_up=(0.9, 1e-3),
    )
    run = stroke(Plant(MODEL, chosen), 0.34, 5.0)
    bent = LAW.breakaway_force / LAW.element_stiffness[0]
    assert (run.velocity > 1e-3).sum() > 100
    assert 0.0 < np.abs(run.deflection).max() <= bent  # a negative level has no end
