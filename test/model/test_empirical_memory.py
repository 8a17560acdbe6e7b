"""Empirical terms with a wave or a memory, against closed forms."""

import math

import pytest

from pneu_rig_ros.model import effects
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE

from .test_effect_physics import GAS, contribute, settle

LAG = 0.3
HALF = GAS.atmospheric_pressure + 2.5e5
"""A pressure whose gauge is half its unit [Pa]."""
WITH_MEMORY = [name for name in effects.names() if name.endswith('_memory')]


def test_force_wave_repeats_after_its_wavelength() -> None:
    values = (2.0, 0.5, 0.04)
    forces = [contribute('empirical_force_wave', values, position=x)[0] for x in (0.01, 0.05)]
    assert forces == pytest.approx([2.0, 2.0])  # a quarter of a wave, and one more
    assert contribute('empirical_force_wave', values, position=0.02)[0] == pytest.approx(-0.5)


@pytest.mark.parametrize(
    ('name', 'values', 'signals', 'start', 'end'),
    [
        ('empirical_friction_memory', (3.0, 0.0, 0.0, 0.0), {'velocity': -0.2}, 0.0, 6.0),
        ('empirical_friction_memory', (0.0, 0.0, 0.0, -1.5), {}, 0.0, -1.5),
        ('empirical_friction_memory', (0.0, 2.0, 0.0, 0.0), {'pressure_1': HALF}, 0.0, 1.0),
        ('empirical_friction_memory', (0.0, 0.0, 4.0, 0.0), {'pressure_2': HALF}, 0.0, 2.0),
        ('empirical_force_memory', (2.0, 0.0), {'velocity': -0.2}, -4.0, 0.0),
        (
            'empirical_force_memory',
            (0.0, 3.0),
            {'pressure_1': 4e5, 'pressure_2': 1.5e5},
            0.0,
            1.5,
        ),
        (
            'empirical_voltage_memory',
            (0.1, 0.0, 0.0, 0.0),
            {'voltage_1': CENTRE_VOLTAGE + 0.5},
            -0.05,
            0.0,
        ),
        ('empirical_voltage_memory', (0.0, 0.0, 0.2, 0.0), {}, 0.0, 0.2),
    ],
)
def test_memory_of_a_step_goes_from_its_start_to_its_end_with_the_lag(
    name: str, values: tuple[float, ...], signals: dict[str, float], start: float, end: float
) -> None:
    for time in (0.0, LAG, 3.0 * LAG):
        state = settle(name, (*values, LAG), time, **signals) if time else ()
        expected = end + (start - end) * math.exp(-time / LAG)
        pair = contribute(name, (*values, LAG), state, **signals)
        assert pair[0] == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_spools_have_a_memory_each() -> None:
    name, signals = 'empirical_voltage_memory', {'voltage_2': CENTRE_VOLTAGE - 0.4}
    values = (0.0, 0.1, 0.0, 0.3, LAG)
    assert contribute(name, values, **signals)[:2] == pytest.approx((0.0, 0.04))
    later = contribute(name, values, settle(name, values, 40.0 * LAG, **signals), **signals)
    assert later[:2] == pytest.approx((0.0, 0.3))


@pytest.mark.parametrize('name', WITH_MEMORY)
def test_states_are_named_as_their_coefficients(name: str) -> None:
    effect = effects.load(name)
    assert effect.describes
    assert set(effect.states) <= set(effect.null._fields)
