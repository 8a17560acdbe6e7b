"""The truth of localisation and its scores, on cases of which the answer is known."""

import numpy as np
import pytest

from pneu_rig_ros.scenarios.hidden import Secret

from . import constants as at
from . import places, rig, systems
from .cases import balances, truth
from .contributions import inertia
from .gas import orifice
from .motion import GRAVITY
from .runs import Run
from .settings import changed
from .systems import SYSTEMS
from .trials import Trial, matrix
from .windows import Window, exceeds, force_window, gas_window, intervals, length, merged, shared

CYLINDER, BALANCES = 'cylinder_1', ('gas_1', 'gas_2', 'force')


def run_of(secret: Secret, index: int = 0) -> Run:
    return rig.runs(CYLINDER, secret, 1.0)[index]


def hidden(**effects: dict[str, float]) -> Secret:
    return Secret(effects, {}, {})


@pytest.mark.parametrize(('order', 'derivative'), [(2, 0), (2, 1), (4, 0), (4, 2)])
def test_noise_of_a_window_is_that_of_its_weights(order: int, derivative: int) -> None:
    window = Window(0.2, 1e-3, order)
    weights = window.weights
    for _ in range(derivative):
        weights = np.gradient(weights, window.interval)
    assert window.noise(derivative) == pytest.approx(np.sqrt(np.sum(weights**2)), rel=0.01)


def test_window_averages_and_has_twenty_samples_at_least() -> None:
    window = gas_window(0.1)
    assert window.length == pytest.approx(2.0)
    assert gas_window(1e-3).length == 0.1
    assert force_window(1e-3).length == 0.07
    assert window.average(np.ones(100))[30:70] == pytest.approx(np.ones(40))


def test_contribution_that_exceeds_the_noise_is_an_interval() -> None:
    window, contribution = gas_window(1e-3), np.zeros(4000)
    contribution[1000:2000], contribution[3000:3500] = -2.0, 0.9
    found = intervals(exceeds(contribution, window, 1.0), 1e-3)
    assert len(found) == 1
    assert found[0] == pytest.approx((1.0, 2.0), abs=1e-3)  # half of the height at the edges


def test_intervals_are_counted_once() -> None:
    told = [(3.0, 4.0), (0.0, 1.0), (0.5, 2.0), (5.0, 5.0)]
    assert merged(told) == [(0.0, 2.0), (3.0, 4.0)]
    assert length(told) == pytest.approx(3.0)
    assert shared(told, [(1.5, 3.5), (3.25, 10.0)]) == pytest.approx(1.5)
    assert intervals(np.array([True, False, True, True]), 0.5) == [(0.0, 0.5), (1.0, 2.0)]


TRUTH = {
    'gas_1': {'fit_1': [(0.0, 4.0)], 'fit_2': []},
    'gas_2': {'fit_1': [(2.0, 6.0)], 'fit_2': []},
    'force': {'fit_1': [], 'fit_2': [(1.0, 2.0)]},
}
TOLD = [
    {'balance': 'gas_2', 'recording': 'fit_1', 'from': 3.0, 'to': 9.0},
    {'balance': 'force', 'recording': 'fit_2', 'from': 1.5, 'to': 2.5},
    {'balance': 'force', 'recording': 'verify_1', 'from': 0.0, 'to': 9.0},
]


@pytest.mark.parametrize(
    ('names', 'expected'),
    [
        (('chamber_leak',), (6.0, 6.0, 3.0)),
        (('friction.coulomb_force',), (1.0, 1.0, 0.5)),
        (('chamber_leak', 'inclination'), (7.0, 7.0, 3.5)),
        (('pressure_offset',), (7.0, 7.0, 3.5)),
        ((), (0.0, 0.0, 0.0)),
    ],
)
def test_times_are_of_the_balances_on_which_the_hidden_acts(
    names: tuple[str, ...], expected: tuple[float, float, float]
) -> None:
    found = places.times(names, TRUTH, TOLD)
    assert (found['true'], found['told'], found['shared']) == pytest.approx(expected)


def test_f1_is_of_time_and_none_where_nothing_shows() -> None:
    rows = [
        {'true': 4.0, 'told': 4.0, 'shared': 3.0},
        {'true': 6.0, 'told': 0.0, 'shared': 0.0},
        {'true': 0.0, 'told': 5.0, 'shared': 0.0},
    ]
    assert places.f1_each(rows) == [0.75, 0.0]
    assert places.f1(rows[:2]) == pytest.approx(6.0 / 14.0)
    assert places.f1(rows[2:]) is None


@pytest.mark.parametrize(
    ('name', 'where', 'right'),
    [
        ('chamber_leak', ['gas_2', 'force'], True),
        ('chamber_leak', ['force', 'gas_2'], False),
        ('cylinder.cap_dead_volume', ['gas_1'], True),
        ('cylinder.moving_mass', ['force'], True),
        ('sensor_delay', ['force'], True),
        ('sensor_delay', [], False),
    ],
)
def test_first_place_is_judged_by_its_group(name: str, where: list[str], right: bool) -> None:
    assert places.place_first({'names': [name], 'where': where}) == right


def test_nothing_hidden_contributes_nothing() -> None:
    run = run_of(Secret({}, {}, {}))
    assert all(not values.any() for values in run.contributions(BALANCES).values())
    assert not any(run.intervals(BALANCES).values())


def test_leak_contributes_its_flow() -> None:
    run = run_of(hidden(chamber_leak={'area_1': 2e-9, 'area_2': 0.0}))
    found, c = run.contributions(BALANCES), run.model.c
    flow = [orifice(p, c[at.P_ATM], 2e-9, c) for p in run.states[:, at.P1]]
    assert found['gas_1'] == pytest.approx(-np.array(flow), rel=1e-6, abs=1e-15)
    assert not found['gas_2'].any()
    assert not found['force'].any()


def test_heat_contributes_as_a_flow_of_energy() -> None:
    run = run_of(hidden(wall_heat_transfer={'conductance_1': 0.5, 'conductance_2': 0.0}))
    c, y = run.model.c, run.states
    volume = c[at.V10] + c[at.A1] * y[:, at.X]
    warmer = c[at.T_S] - y[:, at.P1] * volume / (y[:, at.M1] * c[at.R])
    expected = 0.5 * (c[at.KAPPA] - 1.0) / (c[at.KAPPA] * c[at.R] * c[at.T_S]) * warmer
    assert run.contributions(BALANCES)['gas_1'] == pytest.approx(expected, rel=1e-6, abs=1e-12)


def test_droop_contributes_only_while_the_supply_is_open() -> None:
    run = run_of(hidden(supply_droop={'resistance': 5e8}), 2)
    found = run.contributions(BALANCES)
    for name, voltage in zip(('gas_1', 'gas_2'), run.voltages.T, strict=True):
        shut = voltage < run.model.c[at.U_M]
        assert not found[name][shut].any()
        assert np.abs(found[name][~shut]).max() > 1e-7


def test_weight_contributes_its_force_while_the_piston_slides() -> None:
    run = run_of(hidden(inclination={'angle': 0.06}))
    force = run.contributions(BALANCES)['force']
    weight = inertia(run.model.c, run.model.e) - run.model.c[at.SIGMA_2] * run.model.c[at.T_FLUID]
    slides = force != 0.0
    assert not force[run.sticking].any()
    assert slides.sum() > 0.9 * (~run.sticking).sum()
    assert force[slides] == pytest.approx(-weight * GRAVITY * np.sin(0.06), rel=1e-6)


def test_level_of_friction_contributes_where_it_slides_steadily() -> None:
    secret = Secret({}, {'friction.coulomb_force': 6.0}, {})
    run = run_of(secret, 2)
    force = run.contributions(BALANCES)['force']
    fast = ~run.sticking & (np.abs(run.states[:, at.V]) > 0.1)
    steady = fast & np.roll(fast, 100) & np.roll(fast, -20)
    assert steady.sum() > 50
    # the film is full: F_c alone is left, 2 N more against the motion than the model has
    side = -np.sign(run.states[steady, at.V])
    assert force[steady] == pytest.approx(2.0 * side, abs=0.3)


def test_offset_of_a_pressure_contributes_force_and_flow() -> None:
    run = run_of(hidden(pressure_offset={'offset_1': 2000.0, 'offset_2': 0.0}))
    found, c = run.contributions(BALANCES), run.model.c
    slides = found['force'] != 0.0
    expected = -c[at.A1] * 2000.0
    assert found['force'][slides] == pytest.approx(np.full(slides.sum(), expected), rel=1e-6)
    shut = np.abs(run.voltages[:, 0] - 2.5) < 0.1
    moved = 2000.0 * c[at.A1] * run.states[:, at.V] / (c[at.R] * c[at.T_S])
    assert found['gas_1'][shut] == pytest.approx(moved[shut], abs=1e-12)


def test_dead_volume_contributes_what_it_takes_to_fill_it() -> None:
    system = SYSTEMS['sealed_chambers']
    model = systems.sizes(system, 'k')
    volume = model['cylinder']['cap_dead_volume']
    secret = Secret({}, {'cylinder.cap_dead_volume': 1.2 * volume}, {})
    run = systems.fitted(system, 'k', secret)[0]
    c = run.model.c
    slope = np.gradient(run.states[:, at.P1], run.interval)
    expected = -0.2 * volume * slope / (c[at.KAPPA] * c[at.R] * c[at.T_S])
    found = run.contributions(system.balances)
    scale = np.abs(expected).max()
    assert found['gas_1'][5:-5] == pytest.approx(expected[5:-5], abs=0.02 * scale)
    assert not found['gas_2'].any()
    assert changed(model, secret.truth) != model


def test_truth_of_a_trial_is_of_its_open_balances_and_recordings() -> None:
    trial = next(t for t in matrix() if t.key == 'single/inclination/cylinder_1/medium/1')
    found = truth(trial)
    assert balances(trial) == tuple(found) == BALANCES
    assert list(found['force']) == ['fit_1', 'fit_2', 'fit_3', 'fit_4']
    assert not any(found['gas_1'].values())
    sliding = sum(
        rig.INTERVAL * (~run.sticking).sum() for run in rig.runs(CYLINDER, trial.secret, 1.0)
    )
    assert 0.7 * sliding < length_of(found['force']) < 1.5 * sliding


def length_of(spans: dict[str, list[tuple[float, float]]]) -> float:
    return sum(length(told) for told in spans.values())


def test_rig_with_one_pressure_has_one_balance() -> None:
    nothing = Secret({}, {}, {})
    trial = Trial('x', 'one_pressure', CYLINDER, 1.0, nothing, ())
    assert balances(trial) == ('gas_1',)
