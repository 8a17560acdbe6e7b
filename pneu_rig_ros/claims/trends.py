"""What the paper says of airflow, supply pressure, load and initial position (Fig. 7-10)."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from pneu_rig_ros.claims.captions import MOSTLY_AT_REST
from pneu_rig_ros.claims.experiments import (
    BAR,
    CAPTIONS,
    Experiment,
    Laboratory,
    Stroke,
    medians,
    middle,
)
from pneu_rig_ros.claims.findings import (
    Finding,
    at_least,
    at_most,
    falls,
    falls_throughout,
    grows,
    numbers,
    require_at_least,
    rises_throughout,
    unchanged,
)
from pneu_rig_ros.model.compiled_model import air
from pneu_rig_ros.model.valve import FULL_VOLTAGE, mass_flow

AIRFLOWS = (1.0, 1.5, 2.0, 3.0)
"""
Airflows of Fig. 7, as multiples of the captions' [-], the same for all cylinders.

The text prints 0.28-0.29 V for cylinder 1 only. The flow is proportional to u less the overlap.
"""
OVERLAP = 0.15
"""Command at which the valves begin to open [V]: u_m - 2.5 V, Table 2."""
INTERMEDIATE = 1
"""Number of the airflow that counts as intermediate."""
SUPPLIES = (3.0, 4.0, 5.0, 6.0, 7.0)
"""[bar] (Fig. 8)."""
LOADS = (0.2, 1.9, 3.6, 5.3)
"""[kg] (Fig. 9)."""
LOAD_COMMAND = 0.30
"""[V] (caption of Fig. 9)."""
STARTS = (0.0, 0.2, 0.4, 0.6)
"""Initial positions of Fig. 10, as shares of the stroke [-]: "along the cylinder stroke"."""
VALVE_FLOW = 720.0
"""That each valve can deliver [L/min] (section 2.1)."""


def commands(name: str) -> list[Experiment]:
    """Return the experiments of Fig. 7 with a cylinder."""
    point = CAPTIONS[name]
    opening = point.u - OVERLAP
    return [replace(point, u=OVERLAP + share * opening) for share in AIRFLOWS]


def supplies(name: str) -> list[Experiment]:
    """Return the experiments of Fig. 8 with a cylinder."""
    return [replace(CAPTIONS[name], supply=supply) for supply in SUPPLIES]


def loads(name: str = 'cylinder_1') -> list[Experiment]:
    """Return the experiments of Fig. 9, which has cylinder 1 only."""
    point = replace(CAPTIONS[name], u=LOAD_COMMAND)
    return [replace(point, load_mass=mass) for mass in LOADS]


def starts(name: str) -> list[Experiment]:
    """Return the experiments of Fig. 10 with a cylinder."""
    return [replace(CAPTIONS[name], start=share) for share in STARTS]


def airflow(laboratory: Laboratory) -> Iterator[Finding]:
    """Statement 4 (Fig. 7)."""
    for name in laboratory.cylinders:
        runs = laboratory.perform_all(commands(name))
        counts, times = [run.count for run in runs], [run.time for run in runs]
        fewer = (counts[0] - 1 - counts[-1]) / max(counts[0], 1)
        yield Finding(f'{name}: fewer events', numbers(counts, 'd'), fewer)
        yield Finding(f'{name}: shorter', numbers(times, '.1f') + ' s', falls_throughout(times))
        if name == 'cylinder_3':
            yield require_at_least(f'{name}: small steps remain', runs[-1].count, 5, 'd')
        else:
            says = f'{name}: nearly continuous (at rest under 10 % of the time)'
            share = runs[-1].rest_share(to_end=True)
            yield Finding(says, numbers([share], '.0%'), at_most(share, 0.1))


def intermediate_airflow(laboratory: Laboratory) -> Iterator[Finding]:
    """Statement 12 (Fig. 7): brief sticking, larger slips."""
    for name in laboratory.cylinders:
        experiments = commands(name)
        runs = laboratory.perform_all([experiments[0], experiments[INTERMEDIATE]])
        waits, steps = medians(runs)
        yield Finding(f'{name}: shorter dwells', numbers(waits) + ' s', at_most(*waits[::-1]))
        yield Finding(f'{name}: larger slips', numbers(steps) + ' mm', at_least(*steps[::-1]))


def supply(laboratory: Laboratory) -> Iterator[Finding]:
    """Statement 5 (Fig. 8)."""
    for name in laboratory.cylinders:
        runs = laboratory.perform_all(supplies(name))
        times = [run.time for run in runs]
        waits, steps = medians(runs)
        shorter = falls(np.nan_to_num(waits))  # where nothing sticks any more there is no dwell
        yield Finding(f'{name}: shorter', numbers(times, '.1f') + ' s', falls_throughout(times))
        yield Finding(f'{name}: dwells fall (straight line)', numbers(waits) + ' s', shorter)
        yield Finding(f'{name}: steps rise (straight line)', numbers(steps) + ' mm', grows(steps))
        if name == 'cylinder_3':
            kept = [run.count for run in runs[-2:]]
            says = f'{name}: steps remain at 6 and 7 bar'
            yield Finding(says, numbers(kept, 'd'), at_least(min(kept), 5))


def low_supply(laboratory: Laboratory) -> Iterator[Finding]:
    """Statement 13 (Fig. 8): pronounced steps at 3-4 bar."""
    for name in laboratory.cylinders:
        runs = laboratory.perform_all(supplies(name)[:2])
        shares, counts = [run.rest_share() for run in runs], [run.count for run in runs]
        many, half = at_least(min(counts), 4), at_least(min(shares), 0.5)
        yield Finding(f'{name}: at least four cycles', numbers(counts, 'd'), many)
        yield Finding(f'{name}: {MOSTLY_AT_REST}', numbers(shares, '.0%'), half)


def load(laboratory: Laboratory) -> Iterator[Finding]:
    """Statement 6 (Fig. 9): cylinder 1 at 0.30 V."""
    runs = laboratory.perform_all(loads())
    counts, times = [run.count for run in runs], [run.time for run in runs]
    _, steps = medians(runs)
    few, spread = max(1, round(0.25 * counts[0])), max(counts) - min(counts)
    same = at_most(spread, few) if min(counts) >= 2 else np.nan
    change = times[-1] / times[0] - 1.0
    shorter = min(0.2 + change, -change) / 0.2
    larger = at_least(steps[-1], steps[0])
    says_reach = 'steps throughout the stroke (over at least 80 %) at every load'
    yield Finding(f'cycles nearly unchanged (within {few})', numbers(counts, 'd'), same)
    yield Finding('larger slips', numbers(steps, '.1f') + ' mm', larger)
    yield Finding('stroke slightly shorter (by at most 20 %)', numbers(times) + ' s', shorter)
    yield require_at_least(says_reach, min(run.reach for run in runs), 0.8)


def initial_position(laboratory: Laboratory) -> Iterator[Finding]:
    """
    Statement 7 (Fig. 10).

    Later cycles are governed by the "local balance" of pressures and friction, so they are
    compared where the strokes have a part in common: beyond the furthest start. The number of
    cycles in a stroke cannot stay the same when its length does not.
    """
    for name in laboratory.cylinders:
        runs = laboratory.perform_all(starts(name))
        counts = [run.count for run in runs]
        firsts = [run.cycles[0].dwell if run.cycles else np.nan for run in runs]
        waits, steps = zip(*(_beyond(run, runs[-1].start) for run in runs), strict=True)
        several, longer = at_least(min(counts), 2), rises_throughout(firsts)
        says = f'{name}: later {{}} at the same place unchanged (within 30 %)'.format
        yield Finding(f'{name}: stick-slip, at least two cycles', numbers(counts, 'd'), several)
        yield Finding(f'{name}: longer first dwell', numbers(firsts) + ' s', longer)
        yield Finding(says('dwells'), numbers(waits) + ' s', unchanged(waits, 0.3))
        yield Finding(says('slips'), numbers(steps, '.3g') + ' mm', unchanged(steps, 0.3))


def _beyond(run: Stroke, place: float) -> tuple[float, float]:
    """Return the median dwell [s] and slip [mm] of the later cycles beyond a place [m]."""
    at = np.interp(run.column('breakaway_time', 1), run.run.time, run.run.position)
    beyond = at > place
    return middle(run.dwells[beyond]), 1e3 * middle(run.column('slip', 1)[beyond][:-1])


def valve_flow(laboratory: Laboratory) -> Iterator[Finding]:
    """Statement 16 (section 2.1): the flow of a valve, fully open into the atmosphere."""
    model = laboratory.reading.model(laboratory.cylinders[0])  # all have the same valves
    gas, supply = air(model.gas), BAR * max(SUPPLIES)
    flow = mass_flow(FULL_VOLTAGE, gas.atmospheric_pressure, supply, model.valve, gas)
    litres = 6e4 * flow * gas.gas_constant * 293.15 / 1e5  # at 1 bar and 20 degC (ANR, ISO 8778)
    says = f'fully open at {max(SUPPLIES):g} bar at least {VALVE_FLOW:g} L/min'
    yield Finding(says, f'{litres:.1f} L/min', at_least(litres, VALVE_FLOW))


def guide_friction(laboratory: Laboratory) -> Iterator[Finding]:
    """
    Statement 17 (section 2.1): the guide has 10-15 % of the friction, hardly speed-dependent.

    In the model only F_c depends on nothing, so it must be at least a tenth of the mean friction.
    """
    for stroke in laboratory.captions():
        coulomb = stroke.plant.model.friction.coulomb_force
        first = stroke.cycles[0].breakaway_time if stroke.cycles else 0.0
        moving = stroke.run.time > first
        share = coulomb / float(np.mean(stroke.run.friction_force[moving]))
        says = f'{stroke.experiment.cylinder}: F_c at least 10 % of the mean friction'
        yield require_at_least(says, share, 0.1)
