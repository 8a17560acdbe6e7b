"""How fast the plant is simulated, against general solvers at equal error, and how cost grows."""

import time
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from rich.progress import Progress

from benchmarks import peers
from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.plant import Plant, Trajectory
from pneu_rig_ros.rig import load_configuration

STROKES = {'cylinder_1': 0.29, 'cylinder_2': 0.34, 'cylinder_3': 0.32}
"""Command u [V] of each cylinder, captions of Fig. 4-6."""
LAW = 'revised_lugre'
"""Sticks and slips in all three strokes; the same in every version, whatever is shipped."""
INTERVAL = 1.16e-3
DURATION = 25.0
WANTED = 1e-4
"""Largest error of position and pressures over the run, as a share of full scale [-]."""
PRESSURE_RANGE = 1e6
TOLERANCES = tuple(10.0 ** (-0.5 * half) for half in range(8, 21))
"""Tried from loose to tight, 1e-4 to 1e-10, until the error is as wanted."""
OWN = 'own'
PEERS: dict[str, Callable[[float], peers.Solve]] = {
    'LSODA': partial(peers.scipy_solver, 'LSODA'),
    'Radau': partial(peers.scipy_solver, 'Radau'),
    'CVODE': peers.cvode_solver,
}


class Point(NamedTuple):
    """One solver at one tolerance."""

    solver: str
    tolerance: float
    error: float
    factor: float


class Stroke(NamedTuple):
    """One cylinder's stroke with its reference solution, shape (m, 4)."""

    plant: Plant
    voltages: tuple[float, float]
    samples: Floats
    task: peers.Problem
    reference: Floats


def run(progress: Progress) -> dict[str, Any]:
    """Run all offline benchmarks; return figures that ``__main__.table`` prints."""
    bar = progress.add_task('strokes at equal error', total=len(STROKES) * (2 + len(PEERS)))
    strokes: dict[str, list[dict[str, Any]]] = {name: [] for name in STROKES}
    for name, rows in strokes.items():
        stroke = prepare(name)
        progress.advance(bar)
        for solver in (OWN, *PEERS):
            if (point := fastest(stroke, solver)) is not None:
                rows.append(point._asdict())
            progress.advance(bar)
    factors = {name: rows[0]['factor'] for name, rows in strokes.items()}
    best_peers = {n: max(row['factor'] for row in rows[1:]) for n, rows in strokes.items()}
    return {
        'error_wanted': WANTED,
        'realtime_factor': min(factors.values()),
        'speedup_vs_best_peer': min(factors[n] / best_peers[n] for n in strokes),
        'strokes': strokes,
        'length': cost_against_length(),
    }


def prepare(name: str) -> Stroke:
    """Return a cylinder's stroke with its Radau solution at 1e-10; warms up the compilers."""
    plant = Plant(load_configuration(name, friction=LAW).model)
    u = STROKES[name]
    voltages = (2.5 + u, 2.5 - u)
    samples = np.arange(1, round(DURATION / INTERVAL) + 1, dtype=np.float64) * INTERVAL
    task = peers.problem(plant, voltages)
    reference = peers.run(task, peers.scipy_solver('Radau', 1e-10), samples)
    for make in PEERS.values():
        peers.run(task, make(1e-6), samples[:20])
    simulate(plant, voltages, 20)
    return Stroke(plant, voltages, samples, task, reference[:, :4])


def fastest(stroke: Stroke, solver: str) -> Point | None:
    """Return the first point, from loose to tight, that is as accurate as wanted."""
    for tolerance in TOLERANCES:
        seconds, states = solved(stroke, solver, tolerance)
        if (largest := error(states, stroke)) <= WANTED:
            return Point(solver, tolerance, largest, DURATION / seconds)
    return None


def solved(stroke: Stroke, solver: str, tolerance: float) -> tuple[float, Floats]:
    """Return the least time [s] of several runs, and position, velocity and pressures (m, 4)."""
    if solver != OWN:
        solve = PEERS[solver](tolerance)
        seconds, states = best_time(partial(peers.run, stroke.task, solve, stroke.samples), 2)
        return seconds, states[:, :4]
    stroke.plant.tolerance = tolerance
    count = len(stroke.samples)
    seconds, run = best_time(partial(simulate, stroke.plant, stroke.voltages, count), 5)
    columns = [run.position, run.velocity, run.pressure_1, run.pressure_2]
    return seconds, np.stack(columns, axis=1)


def simulate(plant: Plant, voltages: tuple[float, float], count: int) -> Trajectory:
    """Run a stroke from rest."""
    plant.reset()
    return plant.run(np.tile(voltages, (count, 1)), INTERVAL)


def best_time(action: Callable[[], Any], runs: int) -> tuple[float, Any]:
    """Return the shortest of several wall times [s] and the last result."""
    times = []
    for _ in range(runs):
        begin = time.perf_counter()
        result = action()
        times.append(time.perf_counter() - begin)
    return min(times), result


def error(states: Floats, stroke: Stroke) -> float:
    """Return the largest error of x, p1, p2 as a share of full scale [-]."""
    full_scale = np.array([stroke.plant.model.cylinder.stroke, PRESSURE_RANGE, PRESSURE_RANGE])
    difference = np.abs(states - stroke.reference)[:, [0, 2, 3]] / full_scale
    return float(difference.max())


def cost_against_length() -> dict[str, Any]:
    """
    Return the time for ever longer strokes, and the exponent of its growth (1 is linear).

    And that of the evaluations: towards its end a stroke has more cycles in a second.
    """
    plant = Plant(load_configuration('cylinder_3', friction=LAW).model)
    rows = []
    for duration in (8.0, 16.0, 32.0, 64.0):
        count = round(duration / INTERVAL)
        seconds, _ = best_time(partial(simulate, plant, (2.82, 2.18), count), 25)
        evaluations = plant.counts['evaluations']
        rows.append({'duration_s': duration, 'ms': 1e3 * seconds, 'evaluations': evaluations})
    return {
        'rows': rows,
        'exponent': growth(rows, 'ms'),
        'evaluations_exponent': growth(rows, 'evaluations'),
    }


def growth(rows: list[dict[str, float]], key: str) -> float:
    """Return the exponent with which something grows with the length of the stroke [-]."""
    lengths, values = ([row[name] for row in rows] for name in ('duration_s', key))
    return float(np.polyfit(np.log(lengths), np.log(values), 1)[0])
