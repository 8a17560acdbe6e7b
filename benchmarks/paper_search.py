"""
Search of what the paper leaves open: which setting lets its statements hold.

The readings that are choices (F_s of Eq. 16, exhaust of Eq. 3, "4 bar") are enumerated. With each,
the unprinted quantities of one cylinder at a time are searched: settings are drawn at random
over their whole ranges and looked at by the strokes of the captions; from the best, an
evolution strategy (CMA-ES) goes on, with every statement measured. Nothing that Table 2 prints is
changed. Results are appended to a file of one JSON object a line, and a table is printed::

    python -m benchmarks.paper_search --seconds 60 --seed 1 --out search.jsonl

The settings found are starts for ``pneu-rig claims --reading``, which also measures neighbours.
"""

from __future__ import annotations

import itertools
import json
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import click
import cma
import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.claims.experiments import CYLINDERS, Conditions, Laboratory, Reading, shipped
from pneu_rig_ros.claims.findings import Finding
from pneu_rig_ros.claims.friction import in_strokes
from pneu_rig_ros.claims.readings import reading_values
from pneu_rig_ros.claims.statements import STATEMENTS
from pneu_rig_ros.model.parameters import (
    FILM_NORMALISED,
    FILM_RESTS_BY_SPEED,
    STATIC_FRICTION_READINGS,
)

RANGES = {
    'fluid_time_constant': (1e-3, 0.4),  # [s]
    'element_stiffness': (3e4, 6e5),  # [N/m], one spring
    'stop_velocity': (5e-5, 1e-2),  # [m/s]
    'start_over_stop': (1.0, 10.0),  # [-]
    'film_rest_velocity': (1e-5, 2e-2),  # [m/s]
    'memory_time': (0.03, 30.0),  # [s]
    'rest_time': (10.0, 5e3),  # [s]
}
"""Quantities searched on a logarithmic scale: least and largest value."""
LEAST_FLUID_TIME = 2e-3
"""Below this T is taken as 0 [s]."""
STROKES = {name: shipped(name).cylinder.stroke for name in CYLINDERS}
"""[m]"""
LARGEST_START = 0.45
"""The initial position is searched from 0 to this share of the stroke [-]."""
FEEDS = {'cylinder_1': 12e-3, 'cylinder_2': 6.9e-3, 'cylinder_3': 2.4e-3}
"""Mean speed of the captions' strokes [m/s]; speeds that count as rest should be below it."""
OF_CAPTION = {'cylinder_1': (1, 6), 'cylinder_2': (2,), 'cylinder_3': (3,)}
"""Statements about one cylinder alone."""
CHEAP = (8, 11, 14, 15)
"""Statements that need the strokes of the captions alone."""
OTHERS = (4, 5, 7, 12, 13)
"""Statements that need more strokes, for every cylinder; 6 is about cylinder 1 alone."""
WANTED_MARGIN = 0.1
"""A finding is not asked to hold by more than this [-]."""
FAILED = 0.3
"""Added for each statement that does not hold, so that whole statements count [-]."""
PER_KILOGRAM = 0.01
"""Added for each kilogram that the fluid term of Eq. 9 adds to the moving mass."""
RANDOM_SHARE = 0.3
"""Share of the time for settings drawn at random [-]."""
FULL = 6
"""So many of the best random settings are measured in full before the evolution."""
SPREAD = 0.1
"""First standard deviation of the evolution, as a share of each range [-]."""


READINGS = STATIC_FRICTION_READINGS[::-1]
"""What F_s of Eq. 16 does during the slip, the default's first."""
EXHAUSTS = (2.65, 2.35)
"""Voltage from which the exhaust of Eq. 3 counts: u_m as printed, u_n [V]."""
SUPPLIES = (4e5, 5e5)
"""The 4 bar of the captions as absolute and as gauge pressure [Pa]."""


NEAR = tuple(
    Conditions(**{what: factor}) for what in ('command', 'supply') for factor in (0.95, 1.05)
)
"""Conditions under which a robust setting is measured too."""


class Choice(NamedTuple):
    """What is read in one way or another."""

    reading: str
    exhaust: float
    supply: float


class Outcome(NamedTuple):
    """
    A setting, measured.

    :param loss: what the search makes small [-]
    :param place: in the ranges, 0 to 1, shape (n,)
    :param holds: number of each statement measured -> whether it holds
    """

    loss: float
    place: Floats
    holds: dict[int, bool]


def setting(place: Floats, cylinder: str, choice: Choice) -> dict[str, dict[str, Any]]:
    """Return what differs from the shipped cylinder, section by section, at a place."""
    inside = np.clip(place, 0.0, 1.0)
    values = {
        name: float(low * (high / low) ** share)
        for (name, (low, high)), share in zip(RANGES.items(), inside, strict=False)
    }
    fluid = values['fluid_time_constant']
    return {
        'friction': {
            'static_friction_reading': STATIC_FRICTION_READINGS.index(choice.reading),
            'memory_time': values['memory_time'],
            'fluid_time_constant': fluid if fluid > LEAST_FLUID_TIME else 0.0,
            'element_stiffness': (values['element_stiffness'],),
            'element_limit': (),
            'stop_velocity': values['stop_velocity'],
            'start_velocity': values['stop_velocity'] * values['start_over_stop'],
            'film_rest_velocity': values['film_rest_velocity'],
            'film_reading': FILM_NORMALISED,
            'film_rest_reading': FILM_RESTS_BY_SPEED,
        },
        'valve': {'exhaust_zero_voltage': choice.exhaust},
        'operation': {
            'supply_pressure': choice.supply,
            'rest_time': values['rest_time'],
            'initial_position': float(inside[-1]) * LARGEST_START * STROKES[cylinder],
        },
    }


def measure(
    place: Floats,
    cylinder: str,
    choice: Choice,
    cheap: bool = False,
    conditions: Conditions | None = None,
    ignored: Sequence[int] = (),
) -> Outcome:
    """Measure the statements about a cylinder; the others are as shipped."""
    changes = setting(place, cylinder, choice)
    reading = Reading('searched', {}, {cylinder: changes})
    laboratory = Laboratory(reading, conditions, threads=1, cylinders=(cylinder,))
    numbers = (*OF_CAPTION[cylinder], *CHEAP, *(() if cheap else OTHERS))
    rows = {number: list(STATEMENTS[number - 1].measure(laboratory)) for number in numbers}
    rows[9] = list(in_strokes(laboratory))
    holds = {number: all(f.holds for f in findings) for number, findings in rows.items()}
    counted = rows.keys() - set(ignored)
    loss = sum(shortfall(finding) for number in counted for finding in rows[number])
    loss += FAILED * sum(not holds[number] for number in counted)
    return Outcome(
        loss + implausible(changes['friction'], cylinder) + outside(place), place, holds
    )


def shortfall(finding: Finding) -> float:
    """Return how far a finding is from holding by the wanted margin, far ones on a log scale."""
    short = max(0.0, WANTED_MARGIN - finding.margin) if finding.margin == finding.margin else 3.0
    return 0.8 * short if short < 0.6 else 0.48 + 0.24 * float(np.log1p(min(short, 60.0) - 0.6))


def implausible(friction: Mapping[str, Any], cylinder: str) -> float:
    """Return what is added for added mass, and for speeds above the feed that count as rest."""
    mass = shipped(cylinder).friction.viscous_coefficient * friction['fluid_time_constant']
    feed, half = FEEDS[cylinder], 0.5 * FEEDS[cylinder]
    speeds = {'start_velocity': feed, 'stop_velocity': half, 'film_rest_velocity': half}
    above = sum(max(0.0, float(np.log(friction[key] / at))) for key, at in speeds.items())
    return float(PER_KILOGRAM * mass + 0.25 * above)


def outside(place: Floats) -> float:
    """Return what is added for a place outside the ranges, so that the evolution turns back."""
    return 10.0 * float(np.sum(np.maximum(np.abs(place - 0.5) - 0.5, 0.0) ** 2))


def measure_robustly(
    place: Floats, cylinder: str, choice: Choice, ignored: Sequence[int]
) -> Outcome:
    """Measure as ``measure`` does, and count u and the supply 5 % off half."""
    own = measure(place, cylinder, choice, ignored=ignored)
    near = [measure(place, cylinder, choice, False, each, ignored).loss for each in NEAR]
    return own._replace(loss=0.5 * own.loss + 0.5 * float(np.mean([own.loss, *near])))


def search(
    cylinder: str, choice: Choice, seconds: float, seed: int, robust: bool, ignored: Sequence[int]
) -> tuple[Outcome, int]:
    """Return the best setting found and the number of settings measured."""
    begin, rng, size = time.monotonic(), np.random.default_rng(seed), len(RANGES) + 1
    drawn: list[Outcome] = []
    while len(drawn) < FULL or time.monotonic() - begin < RANDOM_SHARE * seconds:
        drawn.append(measure(rng.random(size), cylinder, choice, cheap=True, ignored=ignored))
    drawn.sort(key=lambda outcome: outcome.loss)
    whole: Callable[..., Outcome] = measure_robustly if robust else measure
    full = [whole(outcome.place, cylinder, choice, ignored=ignored) for outcome in drawn[:FULL]]
    best, count = min(full, key=lambda outcome: outcome.loss), len(drawn) + FULL
    evolution = cma.CMAEvolutionStrategy(best.place, SPREAD, {'seed': seed, 'verbose': -9})
    while time.monotonic() - begin < seconds and not evolution.stop():
        asked = evolution.ask()
        outcomes = [whole(place, cylinder, choice, ignored=ignored) for place in asked]
        evolution.tell(asked, [outcome.loss for outcome in outcomes])
        best = min([best, *outcomes], key=lambda outcome: outcome.loss)
        count += len(outcomes)
    return best, count


@click.command()
@click.option('--seconds', type=float, default=60.0, help='of each search')
@click.option('--seed', type=int, default=1)
@click.option('--cylinder', type=click.Choice(CYLINDERS), multiple=True, default=CYLINDERS)
@click.option('--robust', is_flag=True, help='count u and the supply 5 % off too')
@click.option('--ignore', type=int, multiple=True, help='number of a statement not to count')
@click.option('--out', type=click.Path(path_type=Path), default='search.jsonl')
def main(
    seconds: float,
    seed: int,
    cylinder: Sequence[str],
    robust: bool,
    ignore: Sequence[int],
    out: Path,
) -> None:
    """Search under every reading; append a line of JSON for each to a file."""
    for choice in itertools.starmap(Choice, itertools.product(READINGS, EXHAUSTS, SUPPLIES)):
        for name in cylinder:
            best, count = search(name, choice, seconds, seed, robust, ignore)
            fails = sorted(number for number, held in best.holds.items() if not held)
            found = Reading('searched', {}, {name: setting(best.place, name, choice)})
            line = {
                'cylinder': name,
                **choice._asdict(),
                'seed': seed,
                'settings': count,
                'loss': round(best.loss, 3),
                'fails': fails,
                **reading_values(found),
            }
            with out.open('a') as file:
                file.write(json.dumps(line) + '\n')
            click.echo(f'{name} {choice}: {count} settings, loss {best.loss:.2f}, fails {fails}')


if __name__ == '__main__':
    main()
