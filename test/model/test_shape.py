"""Free shapes of effects: what they multiply, and what is refused."""

from typing import Any

import numpy as np
import pytest

from pneu_rig_ros.batch import run_parallel
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model import effects
from pneu_rig_ros.model.effect import READING_BALANCES, Balance
from pneu_rig_ros.model.plant import Plant, Trajectory
from pneu_rig_ros.model.shape import DRIVERS, Shape, Shaped, factors, rows, with_values
from pneu_rig_ros.rig.configuration import configuration_from_yaml
from pneu_rig_ros.rig.yaml_file import configuration_folder

from .rigs import changed, drive, stroke
from .test_effect_physics import AT_REST, COMPILED, at_rest

pytestmark = pytest.mark.usefixtures('plants')

MODEL = changed('cylinder_2')
LEAK = effects.load('chamber_leak').parameters
CYLINDER = (configuration_folder() / 'cylinder_2.yaml').read_text()
HEAT = (
    'effects: {wall_heat_transfer: {conductance_1: 0.3 W/K, conductance_2: 0.3 W/K, shape: '
    '{over: pressure, at: [1e5 Pa, 3e5 Pa, 5e5 Pa], times: [0.6, 1, 1.3]}}}'
)
OF_ONE_CHAMBER = {'pressure', 'temperature', 'opening'}
SEEN_BY_SENSORS = {
    'position',
    'velocity',
    'speed',
    'pressure',
    'temperature',
    'pressure_1',
    'pressure_2',
    'difference',
    'time',
}
EVERY = [(name, over) for name in effects.causes() for over in effects.load(name).drivers]


def ones(over: str) -> Shape:
    quantity = DRIVERS[over]
    return Shape(over, (max(quantity.low, -1.0), min(quantity.high, 1e6)), (1.0, 1.0))


def library(**chosen: Any) -> dict[str, Any]:
    """Return the parameters of all effects: the plant that most tests share, compiled once."""
    return effects.nulls() | chosen


def same(a: Trajectory, b: Trajectory) -> None:
    for name, column in a._asdict().items():
        assert np.array_equal(column, getattr(b, name)), name


@pytest.mark.parametrize('name', effects.causes())
def test_shape_of_ones_changes_nothing_to_the_last_bit(name: str) -> None:
    effect = effects.load(name)
    if not effect.drivers:
        return
    laws = {'friction': {'model': 0}} if effect.laws else {}
    model = changed('cylinder_2', **laws)
    own = effect.probes[0]
    plain = stroke(Plant(model, library(**{name: own})), 0.5, 1.0)
    for over in effect.drivers:
        shaped = library(**{name: Shaped(own, ones(over))})
        same(stroke(Plant(model, shaped), 0.5, 1.0), plain)


@pytest.mark.parametrize('over', ['pressure', 'position'])
def test_doubled_leak_is_a_leak_of_twice_the_area(over: str) -> None:
    shape = Shape(over, (0.0, 1e6), (2.0, 2.0))
    shaped = Plant(MODEL, library(chamber_leak=Shaped(LEAK(1e-8, 2e-8), shape)))
    doubled = Plant(MODEL, library(chamber_leak=LEAK(2e-8, 4e-8)))
    same(stroke(shaped, 0.5, 1.0), stroke(doubled, 0.5, 1.0))


def test_zero_of_a_sensor_drifts_with_the_time() -> None:
    offset = effects.load('pressure_offset').parameters(1e3, -2e3)
    own = Shaped(offset, Shape('time', (0.0, 1.0), (0.5, 2.0)))
    run = drive(Plant(MODEL, library(pressure_offset=own)), (2.6, 2.4), 2.0)
    factor = np.interp(run.time, (0.0, 1.0), (0.5, 2.0))
    np.testing.assert_allclose(run.pressure_1_reading - run.pressure_1, 1e3 * factor)
    np.testing.assert_allclose(run.pressure_2_reading - run.pressure_2, -2e3 * factor)


def test_state_of_an_effect_is_its_own_whatever_the_shape() -> None:
    """The lag of a valve, times one half: the mean of the voltages with it and without it."""
    lag = effects.load('valve_lag').parameters(0.05)
    shape = Shape('opening', (-2.5, 2.5), (0.5, 0.5))
    half = Plant(MODEL, library(valve_lag=Shaped(lag, shape)))
    whole = Plant(MODEL, library(valve_lag=lag))
    none = Plant(MODEL, library())
    filled = [drive(plant, (3.0, 2.5), 0.04).gas_mass_1[-1] for plant in (none, half, whole)]
    assert filled[0] > filled[1] > filled[2]


def test_factor_is_linear_between_knots_and_constant_beyond() -> None:
    shape = Shape('pressure_1', (1e5, 3e5, 4e5), (1.0, 3.0, 0.5))
    effect = effects.load('pressure_dependent_friction')
    table = rows([('it', effect, Shaped(effect.null, shape))])
    for pressure, expected in ((0.5e5, 1.0), (2e5, 2.0), (3.5e5, 1.75), (9e5, 0.5)):
        signals = at_rest(pressure_1=pressure)
        assert factors(table[0], signals, COMPILED.gas) == pytest.approx((expected, expected))


def test_each_chamber_has_the_factor_of_its_own() -> None:
    effect = effects.load('wall_heat_transfer')
    shape = Shape('pressure', (1e5, 2e5), (1.0, 2.0))
    table = rows([('it', effect, Shaped(effect.null, shape))])
    assert factors(table[0], AT_REST, COMPILED.gas) == pytest.approx((2.0, 1.5))


def test_batch_runs_shapes_as_alone() -> None:
    def plants() -> list[Plant]:
        shapes = [Shape('pressure', (1e5, 5e5), (1.0, k)) for k in (1.0, 2.0)]
        shaped = [library(chamber_leak=Shaped(LEAK(1e-8, 1e-8), shape)) for shape in shapes]
        return [Plant(MODEL, chosen) for chosen in (*shaped, library())]

    voltages = np.tile((3.0, 2.0), (300, 1))
    for one, run in zip(plants(), run_parallel(plants(), voltages, 1e-3), strict=True):
        same(run, one.run(voltages, 1e-3))


def test_rig_file_holds_the_shape() -> None:
    rig = configuration_from_yaml(f'{CYLINDER}\n{HEAT}', 'rig')
    own = rig.effects['wall_heat_transfer']
    assert own.shape == Shape('pressure', (1e5, 3e5, 5e5), (0.6, 1.0, 1.3))
    assert configuration_from_yaml(rig.to_yaml(), 'rig') == rig


@pytest.mark.parametrize(
    ('right', 'wrong', 'message'),
    [
        ('over: pressure', 'over: presure', "shape.over: unknown name 'presure', did you mean"),
        ('over: pressure', 'over: dwell', 'allowed: pressure, temperature, position, speed'),
        ('1e5 Pa', '1 bar', r'shape.at\[0\]: unit bar in .* allowed is Pa'),
        ('1e5 Pa', '4e5 Pa', 'shape.at: expected 2 to 8 increasing values'),
        ('0.6, ', '', 'shape.times: 2 factors for 3 knots'),
        ('0.6', '0.0', r'shape.times\[0\]: 0 is not within 0.01 to 100'),
        ('0.6', '.nan', r'shape.times\[0\]: nan is not within'),
        ('0.6', '0.6 W', 'shape.times: expected a list of numbers'),
        ('over: pressure, ', '', 'shape: expected a mapping with over, at, times'),
        ('[0.6, 1, 1.3]', '1', 'shape.times: expected a list of numbers'),
    ],
)
def test_bad_shape_is_refused_in_one_line(right: str, wrong: str, message: str) -> None:
    assert right in HEAT
    with pytest.raises(RigError, match=f'^rig: effects.wall_heat_transfer.*{message}') as error:
        configuration_from_yaml(f'{CYLINDER}\n{HEAT.replace(right, wrong)}', 'rig')
    assert '\n' not in str(error.value)


def test_another_value_keeps_the_shape() -> None:
    own = Shaped(LEAK(1e-8, 2e-8), ones('pressure'))
    assert with_values(own, {'area_1': 0.0}) == own._replace(parameters=LEAK(0.0, 2e-8))
    assert with_values(own.parameters, {'area_1': 0.0}) == LEAK(0.0, 2e-8)


def test_effect_without_drivers_takes_no_shape() -> None:
    lag = Shaped(effects.load('line_lag').null, ones('time'))
    with pytest.raises(RigError, match=r"effects\.line_lag\.shape\.over: unknown name 'time'"):
        Plant(MODEL, {'line_lag': lag})


@pytest.mark.parametrize(('name', 'over'), EVERY)
def test_drivers_are_there_for_the_balance(name: str, over: str) -> None:
    balance = effects.load(name).balance
    chambers = (
        Balance.SPOOL,
        Balance.SUPPLY,
        Balance.MASS,
        Balance.HEAT,
        Balance.PRESSURE_READING,
    )
    assert over in DRIVERS
    assert over not in OF_ONE_CHAMBER or balance in chambers
    assert over in SEEN_BY_SENSORS or balance not in READING_BALANCES
