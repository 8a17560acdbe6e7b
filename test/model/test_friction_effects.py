"""The friction rungs against Eq. 9-16 and closed forms."""

import math

import numpy as np
import pytest

from pneu_rig_ros.model import effects, friction
from pneu_rig_ros.model.parameters import REVISED_LUGRE_DWELL

from .test_effect_physics import COMPILED, MODEL, contribute, settle

LAW = COMPILED.friction


@pytest.mark.parametrize('sticking', [True, False])
@pytest.mark.parametrize('dwell', [0.0, 0.3, 7.0, 1e6])
def test_static_friction_is_eq_16_at_rest_and_held_in_motion(dwell: float, sticking: bool) -> None:
    ratio = (30.0 - LAW.coulomb_force) / (LAW.breakaway_force - LAW.coulomb_force)
    values = (1.0, 0.2, 0.4, ratio)
    with_dwell = LAW._replace(
        model=REVISED_LUGRE_DWELL, dwell_coefficient=values[1], dwell_exponent=values[2]
    )
    expected = friction.static_friction(dwell, 30.0, LAW.coulomb_force, with_dwell)
    signals = {'dwell_time': dwell, 'sticking': sticking, 'velocity': 0.0 if sticking else 0.1}
    coulomb, static, _ = contribute('dwell_static_friction', values, **signals)
    assert coulomb == 0.0
    assert LAW.breakaway_force + static == pytest.approx(expected)
    assert LAW.coulomb_force - 1e-12 <= LAW.breakaway_force + static <= 30.0 + 1e-12


@pytest.mark.parametrize('lost', [0.0, 0.6])
@pytest.mark.parametrize('dwell', [0.0, 0.3, 1e6])
def test_static_friction_recovers_from_what_a_slip_has_left(lost: float, dwell: float) -> None:
    values = (lost, 0.2, 0.4)
    signals = {'dwell_time': dwell, 'sticking': True, 'velocity': 0.0}
    coulomb, added, _ = contribute('dwell_static_friction', values, **signals)
    lack = lost * (LAW.breakaway_force - LAW.coulomb_force) * math.exp(-0.2 * dwell**0.4)
    assert coulomb == 0.0
    assert added == pytest.approx(-lack)


def test_stribeck_excess_is_whole_at_rest_and_falls_to_1_over_e() -> None:
    values = (6.0, 0.02, 1.5)
    excess = [contribute('stribeck', values, velocity=v)[0] for v in (0.0, 0.02, -0.02, 1.0)]
    assert excess == pytest.approx([6.0, 6.0 / math.e, 6.0 / math.e, 0.0])


def test_film_settles_at_its_share_and_thins_with_its_own_time_at_rest() -> None:
    values = (20.0, 0.02, 0.5, 30.0)
    full = settle('film_dynamics', values, 1.0, velocity=0.2)
    part = settle('film_dynamics', values, 20.0, full, velocity=0.01)
    after = settle('film_dynamics', values, 0.5, full, velocity=1e-9)
    rest = settle('film_dynamics', values, 30.0, full, sticking=True)
    assert full[0] == pytest.approx(1.0)
    assert part[0] == pytest.approx((0.01 * 20.0) ** (2.0 / 3.0))
    assert after[0] == pytest.approx(math.exp(-1.0), rel=1e-4)
    assert rest[0] == pytest.approx(math.exp(-1.0), rel=1e-6)
    assert contribute('film_dynamics', values, part)[:2] == (part[0], 0.0)


def test_fluid_inertia_is_the_mass_sigma_2_t() -> None:
    pair = contribute('fluid_inertia', (0.05,))[:2]
    assert pair == (0.0, pytest.approx(0.05 * LAW.viscous_coefficient))


def test_presliding_loop_is_that_of_a_maxwell_slip_element() -> None:
    stiffness, limit = 1e5, 2.0
    reach, widest = limit / stiffness, 1e-4
    anchor, anchors, forces = np.zeros(1), np.zeros(2), []
    law = LAW._replace(
        element_stiffness=np.array([stiffness, 1.0]), element_limit=np.array([limit])
    )
    path = widest * np.sin(np.linspace(0.0, 4.5 * np.pi, 400))
    for z in path:
        anchor = settle('presliding_hysteresis', (stiffness, limit), 0.02, anchor, deflection=z)
        force = contribute('presliding_hysteresis', (stiffness, limit), anchor, deflection=z)[0]
        friction.drag_anchors(z, anchors, law)
        exact, _ = friction.element_force(z, anchors[0], 0, law)
        assert force == pytest.approx(exact, abs=1e-3 * limit)
        forces.append(force)
    first, last = 44, 400  # from the first extreme on: two whole loops
    force = np.array(forces)[first:last]
    work = np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(path[first:last]))
    assert work == pytest.approx(2.0 * 4.0 * limit * (widest - reach), rel=0.02)


def test_presliding_stiffness_is_that_of_the_element_until_it_slips() -> None:
    stiffnesses = [
        contribute('presliding_hysteresis', (1e5, 2.0), deflection=z)[1]
        for z in (0.0, 1.9e-5, -1.9e-5, 2.1e-5, -2.1e-5)
    ]
    assert stiffnesses == [1e5, 1e5, 1e5, 0.0, 0.0]


@pytest.mark.parametrize('name', [n for n in effects.names() if effects.load(n).laws])
def test_rung_is_missing_in_some_law_but_not_in_all(name: str) -> None:
    assert 'revised_lugre_dwell' not in effects.load(name).laws


def test_friction_is_a_bell_around_its_place() -> None:
    def share(place: float) -> float:
        values = (0.3, 0.6, 0.1)
        x = place * MODEL.cylinder.stroke
        coulomb, static, _ = contribute('local_friction', values, position=x)
        assert coulomb / LAW.coulomb_force == pytest.approx(static / LAW.breakaway_force)
        return float(static / LAW.breakaway_force)

    assert share(0.6) == pytest.approx(0.3)
    assert [share(0.5), share(0.7)] == pytest.approx([0.3 / math.e] * 2)
    assert share(0.0) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(('one_sidedness', 'shares'), [(0.0, (0.2, -0.2)), (1.0, (0.4, 0.0))])
def test_static_friction_differs_by_direction(
    one_sidedness: float, shares: tuple[float, float]
) -> None:
    excess = LAW.breakaway_force - LAW.coulomb_force
    for side, share in zip((1.0, -1.0), shares, strict=True):
        for sticking in (True, False):
            coulomb, static, _ = contribute(
                'direction_dependent_static_friction',
                (0.2, one_sidedness),
                velocity=0.0 if sticking else 0.01 * side,
                bristle_force=side * LAW.coulomb_force,
                sticking=sticking,
            )
            assert coulomb == 0.0
            assert static == pytest.approx(share * excess)


def test_seal_deforms_over_its_reach_and_reverses_over_twice_of_it() -> None:
    limit, reach = 2.0, 3e-4

    def moved(ways: tuple[float, ...]) -> float:
        """Return the force [N] after ways [m] one after the other, at 1 mm/s."""
        state = np.zeros(1)
        for way in ways:
            speed = math.copysign(1e-3, way)
            state = settle('seal_elasticity', (limit, reach), way / speed, state, velocity=speed)
        force, added, _ = contribute('seal_elasticity', (limit, reach), state)
        assert added == 0.0
        return float(force)

    assert moved((0.5 * reach,)) == pytest.approx(-0.5 * limit)
    assert moved((5.0 * reach,)) == pytest.approx(-limit)
    # the way in which the element slips back to its limit is a micrometre
    assert moved((5.0 * reach, -reach)) == pytest.approx(0.0, abs=0.01 * limit)
    assert moved((5.0 * reach, -2.1 * reach)) == pytest.approx(limit)
    assert moved((0.5 * reach, -0.5 * reach)) == pytest.approx(0.0, abs=1e-9)
