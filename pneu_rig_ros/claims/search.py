"""
Search of the quantities that the paper does not print, for one setting of all cylinders.

An evolution: some settings are drawn over the whole range, most are bred from the best ones found
so far, by taking each quantity from one of two parents and moving it. Settings are ranked by the
statements that hold and, below that, by how far the others are from holding. Nothing that Table 2
prints is touched.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pneu_rig_ros.claims.experiments import CYLINDERS, Laboratory, Reading
from pneu_rig_ros.claims.findings import Row, Statement
from pneu_rig_ros.claims.statements import STATEMENTS, measure
from pneu_rig_ros.executor import Executor, map_tasks
from pneu_rig_ros.model.parameters import (
    FILM_NORMALISED,
    FILM_READINGS,
    FILM_REST_READINGS,
    FILM_RESTS_BY_SPEED,
    FOLLOWS_CLOCK,
    STATIC_FRICTION_READINGS,
)

WANTED = (3, 4, 5, 6, 7, 9, 10)
"""Statements that decide between settings under which as many hold."""
LEAST_STIFFNESS = 100.0
"""Elements softer than this, which no configuration may have, are left out [N/m]."""
LEAST_CYCLES = 3
"""A setting is not pursued when a cylinder has fewer cycles in the stroke of its caption."""
CHEAPEST_FIRST = [STATEMENTS[number - 1] for number in (1, 2, 3, 6, 8, 9, 7, 5, 4, 10)]
"""Statements in the order in which the search measures them."""
HOPELESS = 3
"""So many statements are measured, the first ones, of a setting that is not pursued."""
BATCH = 32
"""Settings drawn before the ranking is looked at again."""
PARENTS = 16
"""So many of the best settings are bred from."""
FRESH = 0.4
"""Share of the settings that are drawn over the whole range [-]."""
GIVEN_UP = 1.5
"""A setting that will stay so far behind the score of the best is not measured to the end."""

KEPT_WEIGHT = 5.0
"""So many others a statement counts for that is to be kept."""

OWN_RANGES = {
    'fluid_time_constant': (1e-4, 2.0),  # [s]; below 1 ms it is taken as 0
    'stop_velocity': (1e-4, 6e-2),  # [m/s]
    'start_velocity': (1e-3, 6e-2),  # [m/s], at least the stop velocity
    'film_rest_velocity': (1e-5, 1e-2),  # [m/s]
    'stiffness': (1e4, 5e5),  # [N/m], of all elements together
}
OWN_LINEAR_RANGES = {
    'soft_share': (-0.5, 0.9),  # of the stiffness in elements that slip; none below 0 [-]
    'soft_limit': (0.3, 6.0),  # slip limit of the first of them [N]
}
"""Quantities of each cylinder on its own, as Table 2 gives all others of its friction."""
LOG_RANGES = {
    **{f'{own}.{name}': limits for own in CYLINDERS for name, limits in OWN_RANGES.items()},
    'rest_time': (0.5, 6e3),  # [s]
}
"""Quantities searched on a logarithmic scale: least and largest value."""
LINEAR_RANGES = {
    **{f'{own}.{name}': at for own in CYLINDERS for name, at in OWN_LINEAR_RANGES.items()},
    'initial_position': (0.0, 0.1),  # [m]
}
"""Quantities searched on a linear scale: least and largest value."""
CHOICES = {
    'static_friction_reading': len(STATIC_FRICTION_READINGS),
    'film_reading': len(FILM_READINGS),
    'film_rest_reading': len(FILM_REST_READINGS),
}
"""Readings searched: number of alternatives."""

Genes = dict[str, float]
"""Name -> place of a quantity in its range, 0 to 1, or index of a reading."""


def genes_of(values: Mapping[str, float]) -> Genes:
    """Return a setting from its quantities in SI units and the indices of its readings."""
    genes: Genes = {name: values[name] for name in CHOICES}
    for name, (low, high) in LOG_RANGES.items():
        genes[name] = float(np.log(max(values[name], low) / low) / np.log(high / low))
    for name, (low, high) in LINEAR_RANGES.items():
        genes[name] = (values[name] - low) / (high - low)
    return genes


START = genes_of({
    'static_friction_reading': FOLLOWS_CLOCK, 'film_reading': FILM_NORMALISED,
    'film_rest_reading': FILM_RESTS_BY_SPEED,
    'cylinder_1.fluid_time_constant': 0.13, 'cylinder_1.film_rest_velocity': 1.05e-3,
    'cylinder_1.stop_velocity': 2.6e-2, 'cylinder_1.start_velocity': 4.14e-2,
    'cylinder_2.fluid_time_constant': 0.34, 'cylinder_2.film_rest_velocity': 9e-5,
    'cylinder_2.stop_velocity': 5.55e-3, 'cylinder_2.start_velocity': 5.55e-3,
    'cylinder_3.fluid_time_constant': 0.0, 'cylinder_3.film_rest_velocity': 1.065e-3,
    'cylinder_3.stop_velocity': 2.13e-2, 'cylinder_3.start_velocity': 2.16e-2,
    'rest_time': 1060.0, 'initial_position': 0.0,
    'cylinder_1.stiffness': 3.9e4, 'cylinder_1.soft_share': -0.5, 'cylinder_1.soft_limit': 3.0,
    'cylinder_2.stiffness': 2.65e4, 'cylinder_2.soft_share': -0.5, 'cylinder_2.soft_limit': 3.0,
    'cylinder_3.stiffness': 6.2e4, 'cylinder_3.soft_share': 0.318, 'cylinder_3.soft_limit': 3.94,
})  # fmt: skip
"""A setting that each search tries first: the default."""


@dataclass(frozen=True)
class Outcome:
    """
    How one setting fares.

    :param genes: where in its range each quantity is
    :param margins: number of each statement measured -> its margin [-], see ``Row``
    :param shortfall: number of each statement measured -> its shortfall [-], see ``Row``
    :param pursued: whether all statements were measured
    :param keep: number of a statement that counts for more than the others, if any
    """

    genes: Genes
    margins: dict[int, float]
    shortfall: dict[int, float]
    pursued: bool
    keep: int | None = None

    @property
    def reading(self) -> Reading:
        """The setting."""
        return reading_of(self.genes)

    @property
    def holds(self) -> dict[int, bool]:
        """Number of each statement measured -> whether it holds."""
        return {number: margin >= 0.0 for number, margin in self.margins.items()}

    @property
    def score(self) -> tuple[bool, float, int]:
        """
        What the best has most of.

        A statement counts for 1 when it holds, and by its shortfall less than that when it does
        not; between equals those of ``WANTED`` decide.
        """
        smooth = sum(
            weight(number, self.keep) * (held - self.shortfall[number])
            for number, held in self.holds.items()
        )
        return self.pursued, smooth, sum(self.holds.get(number, False) for number in WANTED)


def weight(number: int, keep: int | None) -> float:
    """Return how much a statement counts [-]."""
    return KEPT_WEIGHT if number == keep else 1.0


def search(
    count: int, seed: int, executor: Executor, progress: Callable[[int], None] = lambda _: None,
    statements: Sequence[Statement] = CHEAPEST_FIRST, keep: int | None = None,
) -> list[Outcome]:  # fmt: skip
    """
    Return the settings tried, best first.

    :param count: number of settings
    :param seed: makes the search repeatable, wherever it is run
    :param executor: where settings are measured
    :param progress: told the number of settings done
    :param statements: that count, in the order in which they are measured
    :param keep: number of a statement that is to hold before all others, if any
    """
    rng = np.random.default_rng(seed)
    outcomes: list[Outcome] = []
    while len(outcomes) < count:
        batch = draw(rng, outcomes, min(BATCH, count - len(outcomes)))

        def told(done: int, before: int = len(outcomes)) -> None:
            progress(before + done)

        outcomes += map_tasks(
            executor, evaluate, batch, bar(outcomes), statements, keep, progress=told
        )
        outcomes.sort(key=lambda outcome: outcome.score, reverse=True)
    return outcomes


def bar(best: list[Outcome]) -> float:
    """Return the score below which a setting is neither bred from nor worth its time."""
    if not (best and best[0].pursued):
        return -np.inf
    behind = best[0].score[1] - GIVEN_UP
    full = len(best) >= PARENTS and best[PARENTS - 1].pursued
    return max(behind, best[PARENTS - 1].score[1]) if full else behind


def draw(rng: np.random.Generator, best: list[Outcome], count: int) -> list[Genes]:
    """Return settings: the known one first, then over the whole range and bred from the best."""
    known = [] if best else [START]
    return known[:count] + [
        breed(rng, [outcome.genes for outcome in best[:PARENTS]])
        if len(best) >= BATCH and rng.random() > FRESH
        else anywhere(rng)
        for _ in range(count - len(known))
    ]


def anywhere(rng: np.random.Generator) -> Genes:
    """Return a setting drawn over the whole range."""
    places = {name: float(rng.random()) for name in (*LOG_RANGES, *LINEAR_RANGES)}
    return places | {name: int(rng.integers(size)) for name, size in CHOICES.items()}


def breed(rng: np.random.Generator, parents: list[Genes]) -> Genes:
    """Return a setting between two others, the better ones preferred, and moved."""
    one, two = (parents[int(len(parents) * rng.random() ** 2)] for _ in range(2))
    width = 0.2 * 10.0 ** rng.uniform(-1.5, 0.0)
    fresh, child = anywhere(rng), {}
    for name in one:
        child[name] = (one if rng.random() < 0.7 else two)[name]
        if name in CHOICES:
            child[name] = fresh[name] if rng.random() < 0.05 else child[name]
        elif rng.random() < 0.5:
            child[name] = float(np.clip(child[name] + rng.normal(0.0, width), 0.0, 1.0))
    return child


def reading_of(genes: Genes) -> Reading:
    """Return the setting as a reading."""
    value = {name: low * (high / low) ** genes[name] for name, (low, high) in LOG_RANGES.items()}
    value |= {n: low + (high - low) * genes[n] for n, (low, high) in LINEAR_RANGES.items()}
    friction = {name: int(genes[name]) for name in CHOICES}
    conditions = {name: value[name] for name in ('rest_time', 'initial_position')}
    single = {
        own: _own({name: value[f'{own}.{name}'] for name in (*OWN_RANGES, *OWN_LINEAR_RANGES)})
        for own in CYLINDERS
    }
    return Reading('searched', friction, conditions, single)


def _own(value: dict[str, float]) -> dict[str, Any]:
    """Return the friction of one cylinder, in which no two quantities contradict each other."""
    time = value['fluid_time_constant']
    return {
        'fluid_time_constant': time if time >= 1e-3 else 0.0,
        'stop_velocity': value['stop_velocity'],
        'start_velocity': max(value['start_velocity'], value['stop_velocity']),
        'film_rest_velocity': value['film_rest_velocity'],
        **_elements(value['stiffness'], value['soft_share'], value['soft_limit']),
    }


def _elements(stiffness: float, share: float, limit: float) -> dict[str, tuple[float, ...]]:
    """Return F(z): a spring alone, or with three elements that slip one after the other."""
    parts = np.array([0.5, 0.3, 0.2]) * share
    if stiffness * parts[-1] < LEAST_STIFFNESS:
        return {'element_stiffness': (stiffness,), 'element_limit': ()}
    springs = tuple(float(stiffness * part) for part in (*parts, 1.0 - share))
    return {'element_stiffness': springs, 'element_limit': (limit, limit, limit)}


def evaluate(
    genes: Genes, bar: float = -np.inf, statements: Sequence[Statement] = CHEAPEST_FIRST,
    keep: int | None = None,
) -> Outcome:  # fmt: skip
    """
    Measure the statements under one setting, as long as it may still be among the best.

    :param genes: the setting
    :param bar: it is given up when its score will be below this, or when a cylinder hardly sticks
    :param statements: that count, in the order in which they are measured
    :param keep: number of a statement that counts for more than the others, if any
    """
    laboratory = Laboratory(reading_of(genes))
    sticks = min(stroke.count for stroke in laboratory.captions()) >= LEAST_CYCLES
    rows: list[Row] = []
    first = sorted(statements, key=lambda statement: statement.number)[:HOPELESS]
    for statement in statements if sticks else first:
        rows.append(measure(laboratory, statement))
        failed = sum(
            weight(row.statement.number, keep) * (1.0 + row.shortfall)
            for row in rows if not row.holds
        )  # fmt: skip
        if sum(weight(one.number, keep) for one in statements) - failed < bar:
            break
    return Outcome(
        genes,
        {row.statement.number: row.margin for row in rows},
        {row.statement.number: row.shortfall for row in rows},
        len(rows) == len(statements),
        keep,
    )
