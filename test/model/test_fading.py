"""Eq. 16 with a memory: F_s - F_c fades while the piston slides, and grows on from there."""

import itertools
import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from pneu_rig_ros.model import dynamics, events, friction
from pneu_rig_ros.model import layout as at
from pneu_rig_ros.model.compiled_model import compiled_model
from pneu_rig_ros.model.parameters import FADES_WHILE_SLIDING, FOLLOWS_CLOCK, Friction, Model
from pneu_rig_ros.model.plant import Plant, Trajectory
from pneu_rig_ros.model.run import Impose

from .rigs import CAPTION_COMMANDS, CYLINDERS, INTERVAL, changed, stroke, worst

SHARE = 1e-5
"""Of full scale: two solutions of one problem."""
NO_MEMORY, FULL_MEMORY = 1e-9, 1e12
"""Memory times beyond what a configuration may have [s]."""


def fading(cylinder: str, memory_time: float, **law: Any) -> Model:
    """Return a cylinder whose static friction fades while sliding."""
    keys = {'static_friction_reading': FADES_WHILE_SLIDING, 'memory_time': memory_time, **law}
    return changed(cylinder, friction=keys)


class Seal:
    """The memory of a seal that is told when it slides and when it rests."""

    def __init__(self, law: Friction, rested: float = 0.0) -> None:
        self.law, self.time = law, 0.0
        self.memory = np.zeros(at.ANCHORS + 1)
        self.memory[[at.STICKING, at.REST_START]] = 1.0, -rested

    def static(self, later: float = 0.0) -> float:
        """Return F_s [N] some time from now [s]."""
        law = self.law
        return dynamics.static_forces(
            self.time + later, self.memory, law.breakaway_force, law.coulomb_force, law
        )[0]

    def after(self, duration: float) -> 'Seal':
        """Let time [s] go by."""
        self.time += duration
        return self

    def slide(self, duration: float) -> 'Seal':
        """Break away, and come to rest after a time [s]."""
        events.break_away(self.time, self.memory, self.static(), self.law)
        events.enter_rest(self.after(duration).time, self.memory, self.law)
        return self


def law_of(cylinder: str, memory_time: float, **law: Any) -> Friction:
    return compiled_model(fading(cylinder, memory_time, **law)).friction


def equation_16(dwell: float, law: Friction) -> float:
    growth = law.dwell_coefficient * dwell**law.dwell_exponent
    return law.breakaway_force - (law.breakaway_force - law.coulomb_force) * math.exp(-growth)


@pytest.mark.parametrize('rested', [0.01, 1.0, 1060.0, 1e7])
@pytest.mark.parametrize('cylinder', CYLINDERS)
def test_static_friction_decays_exponentially_while_sliding(cylinder: str, rested: float) -> None:
    law = law_of(cylinder, 0.7)
    seal = Seal(law, rested)
    above = equation_16(rested, law) - law.coulomb_force
    assert seal.static() == pytest.approx(law.coulomb_force + above)
    events.break_away(0.0, seal.memory, seal.static(), law)
    for slid in (0.0, 1e-6, 0.01, 0.7, 5.0):
        expected = law.coulomb_force + above * math.exp(-slid / 0.7)
        assert seal.static(slid) == pytest.approx(expected, rel=1e-12)
    assert seal.static(1e5) == law.coulomb_force


@pytest.mark.parametrize('slid', [0.05, 1.0, 6.0])
@pytest.mark.parametrize('cylinder', CYLINDERS)
def test_clock_goes_on_from_the_dwell_that_has_given_what_is_left(
    cylinder: str, slid: float
) -> None:
    law = law_of(cylinder, 2.0)
    left = law.coulomb_force + (equation_16(10.0, law) - law.coulomb_force) * math.exp(-slid / 2.0)
    before = brentq(lambda dwell: equation_16(dwell, law) - left, 0.0, 10.0, xtol=1e-14)
    seal = Seal(law, 10.0).slide(slid)
    assert seal.static() == pytest.approx(left, rel=1e-12)
    for rested in (1e-9, 0.1, 3.0, 1e4):
        assert seal.static(rested) == pytest.approx(equation_16(before + rested, law), rel=1e-9)


def test_static_friction_is_continuous_over_a_thousand_slips() -> None:
    seal = Seal(law_of('cylinder_1', 0.3), 1.0)
    for _ in range(1000):
        before = seal.after(0.02).static()
        assert seal.slide(0.0).static() == pytest.approx(before, rel=1e-9)
        seal.slide(0.01)
    law, share = seal.law, math.exp(-0.01 / 0.3)
    # as much as a rest lets it grow, a slip takes away
    grown = seal.after(0.02).static() - law.coulomb_force
    seal.slide(0.01)
    assert seal.static() - law.coulomb_force == pytest.approx(share * grown, rel=1e-9)
    assert seal.after(0.02).static() - law.coulomb_force == pytest.approx(grown, rel=1e-6)


def test_without_memory_the_clock_begins_anew_and_with_a_full_one_rests_add_up() -> None:
    forgets, keeps = (Seal(law_of('cylinder_2', t), 5.0) for t in (NO_MEMORY, FULL_MEMORY))
    rested = 5.0
    for dwell in (0.3, 7.0, 0.01, 40.0):
        anew = equation_16(dwell, forgets.law)
        assert forgets.slide(0.2).after(dwell).static() == pytest.approx(anew, rel=1e-12)
        rested += dwell
        expected = equation_16(rested, keeps.law)
        assert keeps.slide(0.2).after(dwell).static() == pytest.approx(expected, rel=1e-9)


BOUNDS = {
    'gamma': (0.0, 1e-6, 0.2, 1e3),
    'alpha': (0.01, 0.45, 2.0),
    'memory': (1e-3, 5.0, 1e6),
    'dwell': (0.0, 1e-12, 1.0, 1e7),
    'slid': (0.0, 1e-12, 1.0, 1e7),
}


def test_nothing_is_lost_at_the_bounds_of_the_parameters() -> None:
    for gamma, alpha, memory, dwell, slid in itertools.product(*BOUNDS.values()):
        law = law_of('cylinder_1', memory, dwell_coefficient=gamma, dwell_exponent=alpha)
        left = friction.faded_dwell(dwell, slid, law)
        assert math.isfinite(left)
        above = (equation_16(dwell, law) - law.coulomb_force) * math.exp(-slid / memory)
        found = equation_16(left, law) - law.coulomb_force
        finest = max(1e-13, gamma * math.nextafter(0.0, 1.0) ** alpha)
        full = law.breakaway_force
        assert found == pytest.approx(above, abs=finest * full), (gamma, alpha, dwell)


def level(plant: Plant, memory: Any, time: float) -> float:
    """Return g [N] without a film at a creep, from the right-hand side."""
    model, creep = compiled_model(plant.model), 1e-4
    point = plant.initial_integrator_state().end._replace(memory=memory)
    point.state[[at.VELOCITY, at.DEFLECTION]] = creep, 1e-5
    plant.right_hand_side(time, point, model)
    bristles = 1e-5 * sum(plant.model.friction.element_stiffness)
    return creep * bristles / (creep - point.rate[at.DEFLECTION])


def test_the_plant_slides_on_a_level_that_fades() -> None:
    plant = Plant(fading('cylinder_1', 0.4))
    law, memory = compiled_model(plant.model).friction, plant.initial_integrator_state().end.memory
    rested = plant.model.operation.rest_time
    events.break_away(2.0, memory, 0.0, law)
    above = equation_16(2.0 + rested, law) - law.coulomb_force
    above *= math.exp(-((1e-4 / law.stribeck_velocity) ** law.stribeck_exponent))
    for slid in (0.0, 0.1, 1.0):
        expected = law.coulomb_force + above * math.exp(-slid / 0.4)
        assert level(plant, memory, 2.0 + slid) == pytest.approx(expected, rel=1e-9)


def slips(run: Trajectory) -> int:
    return int(np.count_nonzero(np.diff(run.sticking.astype(int)) < 0))


@pytest.mark.parametrize('cylinder', CYLINDERS)
def test_a_memory_too_short_to_matter_is_the_clock_that_is_reset(cylinder: str) -> None:
    tight = {'tolerance': 1e-8}
    clock = changed(cylinder, friction={'static_friction_reading': FOLLOWS_CLOCK})
    u = CAPTION_COMMANDS[cylinder]
    wanted = stroke(Plant(clock, **tight), u, 6.0)
    found = stroke(Plant(fading(cylinder, NO_MEMORY), **tight), u, 6.0)
    kept = stroke(Plant(fading(cylinder, 1.0), **tight), u, 6.0)
    assert slips(wanted) >= 1
    assert worst(wanted.position, found.position, clock.cylinder.stroke) < SHARE
    assert worst(wanted.position, kept.position, clock.cylinder.stroke) > 100.0 * SHARE


def pushes(model: Model) -> tuple[Plant, np.ndarray]:
    """Return a plant, and voltages that push its piston out and in with pauses, shape (m, 2)."""
    rng = np.random.default_rng(5)
    ways = np.tile([1.0, 0.0, -1.0, 0.0], 3)
    u = np.repeat(ways * rng.uniform(0.4, 0.7, ways.size), 500)
    return Plant(model), np.stack([2.5 + u, 2.5 - u], axis=1)


def test_with_a_full_memory_the_rests_of_a_run_add_up() -> None:
    model = fading('cylinder_2', FULL_MEMORY)
    model = model._replace(operation=model.operation._replace(rest_time=0.5))
    plant, voltages = pushes(model)
    run = plant.run(voltages, INTERVAL)
    assert slips(run) >= 3
    memory, law = plant._carry.end.memory, plant._arguments.friction
    rested = 0.5 + INTERVAL * np.count_nonzero(run.sticking)
    error = INTERVAL * (2 * slips(run) + 1)
    assert dynamics.dwell_clock(run.time[-1], memory, law) == pytest.approx(rested, abs=error)


def test_a_run_that_fades_is_the_same_however_it_is_cut() -> None:
    plant, voltages = pushes(fading('cylinder_2', 0.5))
    whole = plant.run(voltages, INTERVAL)
    assert slips(whole) >= 3
    plant.reset()
    pieces = [plant.run(p, INTERVAL) for p in np.split(voltages, [1, 2, 700, 701, 2500])]
    plant.reset()
    states = [plant.step(*row, INTERVAL) for row in voltages]
    for name, column in whole._asdict().items():
        joined = np.concatenate([getattr(piece, name) for piece in pieces])
        assert np.array_equal(joined, column), name
        assert [getattr(state, name) for state in states] == column.tolist(), name


def followed(actions: dict[int, int], rests: dict[int, float]) -> tuple[Plant, float]:
    """Return a plant that rested 5 s before and follows shut valves, and the time then [s]."""
    model = fading('cylinder_1', 0.5)
    model = model._replace(operation=model.operation._replace(rest_time=5.0))
    plant, count = Plant(model), 200
    todo, begins = np.zeros(count, dtype=np.int64), np.zeros(count)
    for sample, action in actions.items():
        todo[sample], begins[sample] = action, rests.get(sample, 0.0)
    measured = np.tile([0.05, 0.0, 1e5, 1e5], (count, 1))
    shut = np.full((count, 2), 2.5)
    return plant, float(plant.run_imposed(shut, INTERVAL, todo, measured, begins).time[-1])


def dwell_of(plant: Plant, time: float) -> float:
    return dynamics.dwell_clock(time, plant._carry.end.memory, plant._arguments.friction)


def test_a_slide_cannot_have_begun_before_the_rest_it_ends() -> None:
    plant, end = followed({100: Impose.HOLD | Impose.BREAK}, {100: -50.0})
    assert dwell_of(plant, end) == pytest.approx(100 * INTERVAL, abs=INTERVAL)


def test_a_slide_that_was_missed_fades_all_the_same() -> None:
    plant, end = followed({100: Impose.HOLD | Impose.BREAK}, {100: 30 * INTERVAL})
    law = plant._arguments.friction
    left = friction.faded_dwell(5.0 + 30 * INTERVAL, 70 * INTERVAL, law)
    assert plant.state.sticking
    assert dwell_of(plant, end) == pytest.approx(left + 100 * INTERVAL, abs=INTERVAL)
