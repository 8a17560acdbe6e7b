"""Plants that run together give the bits of each alone, whatever they are and how many."""

from collections.abc import Iterator

import numpy as np
import pytest

from pneu_rig_ros.batch import END_SHARE, run_parallel, strokes
from pneu_rig_ros.model import effects
from pneu_rig_ros.model.parameters import FADES_WHILE_SLIDING
from pneu_rig_ros.model.plant import Plant, Trajectory
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.rig.valve_drive import valve_voltages

INTERVAL = 1.16e-3
COMMANDS = (0.3, 0.45, 0.8, -0.5, 0.35)
LEAK = effects.nulls() | {'chamber_leak': effects.load('chamber_leak').probes[0]}


def plants() -> Iterator[Plant]:
    """Yield plants of three cylinders, two laws and readings, several loads, with an effect."""
    for number, u in enumerate(COMMANDS):
        name = f'cylinder_{number % 3 + 1}'
        law = 'lugre' if number == 3 else 'revised_lugre_dwell'
        rig = load_configuration(
            name, load_mass=0.2 + number, friction=law, initial_position=0.05 if u > 0 else 0.1
        )
        seal = rig.model.friction
        if number == 1:
            seal = seal._replace(static_friction_reading=FADES_WHILE_SLIDING, memory_time=0.3)
        yield Plant(rig.model._replace(friction=seal), LEAK if number == 4 else None)


def voltages(samples: int) -> np.ndarray:
    """Return u1, u2 of each plant, a step halfway, shape (n, m, 2)."""
    held = np.array([valve_voltages(u) for u in COMMANDS])
    every = np.repeat(held[:, None], samples, axis=1)
    every[:, samples // 2 :, 0] += 0.1
    return every


def same(one: Trajectory, other: Trajectory) -> bool:
    """Return whether two runs agree in every bit."""
    return all(a.tobytes() == b.tobytes() for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize('threads', [1, 2, None])
def test_same_bits_as_alone_also_when_it_goes_on(threads: int | None) -> None:
    together, alone = list(plants()), list(plants())
    for samples in (700, 501):
        held = voltages(samples)
        runs = run_parallel(together, held, INTERVAL, threads)
        for plant, own, run, v in zip(alone, together, runs, held, strict=True):
            assert same(plant.run(v, INTERVAL), run)
            assert plant.state == own.state
            assert plant.counts == own.counts


def test_one_row_of_voltages_is_for_all() -> None:
    held = voltages(300)[0]
    runs = run_parallel(list(plants()), held, INTERVAL)
    for plant, run in zip(plants(), runs, strict=True):
        assert same(plant.run(held, INTERVAL), run)


def test_no_plants_are_no_runs() -> None:
    assert run_parallel([], np.zeros((3, 2)), INTERVAL) == []


def test_strokes_end_where_the_piston_gets() -> None:
    rigs = [load_configuration('cylinder_2', initial_position=0.1) for _ in range(3)]
    held = np.array([valve_voltages(u) for u in (1.0, -1.0, 0.0)])
    out, back, none = strokes([Plant(rig.model) for rig in rigs], held, INTERVAL, 12.0)
    length = rigs[0].model.cylinder.stroke
    assert out.position[-1] >= END_SHARE * length > out.position[-2]
    assert back.position[-1] <= (1 - END_SHARE) * length < back.position[-2]
    assert len(none.time) == round(12.0 / INTERVAL)
