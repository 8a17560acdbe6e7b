"""
Search of the quantities that the paper does not print, for one setting of all cylinders.

Half of the settings are drawn at random over the whole range, half next to the best ones found so
far. Nothing that Table 2 prints is touched.
"""

import signal
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from pneu_rig_ros.claims.experiments import Laboratory, Reading
from pneu_rig_ros.claims.statements import STATEMENTS, measure
from pneu_rig_ros.model.parameters import FILM_READINGS, STATIC_FRICTION_READINGS

WANTED = (3, 4, 5, 6, 7, 9, 10)
"""Statements that count before the others."""
BATCH = 16
"""Settings drawn before the ranking is looked at again."""
PARENTS = 12
"""So many of the best settings have others drawn next to them."""
TOLERANCE = 1e-5


@dataclass(frozen=True)
class Outcome:
    """
    How one setting fares.

    :param reading: the setting
    :param holds: number of each statement -> whether it holds
    :param share: number of each statement -> share of its findings that hold [-]
    """

    reading: Reading
    holds: dict[int, bool]
    share: dict[int, float]

    @property
    def rank(self) -> tuple[float, float, float]:
        """What the best has most of: wanted statements, their findings, all findings."""
        wanted = sum(self.holds[number] for number in WANTED)
        findings = sum(self.share[number] for number in WANTED)
        return wanted, findings, sum(self.share.values())


def search(
    count: int, seed: int, workers: int, progress: Callable[[int], None] = lambda _: None
) -> list[Outcome]:
    """
    Return the settings tried, best first.

    :param count: number of settings
    :param seed: makes the search repeatable, whatever the number of workers
    :param workers: processes
    :param progress: told the number of settings done
    """
    rng = np.random.default_rng(seed)
    outcomes: list[Outcome] = []
    pool = ProcessPoolExecutor(workers, initializer=_leave_interrupts_to_the_parent)
    try:
        while len(outcomes) < count:
            done = len(outcomes)
            batch = list(draw(rng, outcomes, min(BATCH, count - done)))
            for outcome in pool.map(evaluate, batch):
                outcomes.append(outcome)
                progress(len(outcomes))
            outcomes.sort(key=lambda outcome: outcome.rank, reverse=True)
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
    return outcomes


def _leave_interrupts_to_the_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def draw(rng: np.random.Generator, best: list[Outcome], count: int) -> Iterator[Reading]:
    """Yield settings: over the whole range, and next to the best."""
    for index in range(count):
        if best and index % 2:
            parent = best[int(rng.integers(min(PARENTS, len(best))))].reading
            yield neighbour(rng, parent)
        else:
            yield anywhere(rng)


def anywhere(rng: np.random.Generator) -> Reading:
    """Return a setting drawn over the whole range."""
    stop = 10 ** rng.uniform(-3.7, -2.0)
    elements = 1 if rng.random() < 0.6 else int(rng.integers(2, 5))
    total = 10 ** rng.uniform(4.3, 5.6)
    friction: dict[str, Any] = {
        'static_friction_reading': int(rng.integers(len(STATIC_FRICTION_READINGS))),
        'film_reading': int(rng.integers(len(FILM_READINGS))),
        'fluid_time_constant': 0.0 if rng.random() < 0.5 else 10 ** rng.uniform(-3.0, -0.5),
        'stop_velocity': stop,
        'start_velocity': stop * 10 ** rng.uniform(0.0, 1.2),
        'element_stiffness': tuple(total * part for part in rng.dirichlet(np.ones(elements))),
        'element_limit': tuple(10 ** rng.uniform(-0.3, 1.0, elements - 1)),
    }
    return _checked(friction, 10 ** rng.uniform(0.0, 3.8))


def neighbour(rng: np.random.Generator, parent: Reading) -> Reading:
    """Return a setting next to another: numbers within some 20 %, names mostly kept."""

    def near(value: float) -> float:
        return float(value * np.exp(rng.normal(0.0, 0.2)))

    old = parent.friction
    friction: dict[str, Any] = {
        'static_friction_reading': old['static_friction_reading'],
        'film_reading': int(rng.integers(2)) if rng.random() < 0.2 else old['film_reading'],
        'fluid_time_constant': near(old['fluid_time_constant']),
        'stop_velocity': near(old['stop_velocity']),
        'start_velocity': near(old['start_velocity']),
        'element_stiffness': tuple(near(k) for k in old['element_stiffness']),
        'element_limit': tuple(near(w) for w in old['element_limit']),
    }
    return _checked(friction, near(parent.rest_time or 1.0))


def _checked(friction: dict[str, Any], rest_time: float) -> Reading:
    """Return the setting with every value inside its allowed range."""
    stiffness = tuple(max(float(k), 200.0) for k in friction['element_stiffness'])
    start = max(float(friction['start_velocity']), float(friction['stop_velocity']))
    plain = {
        'fluid_time_constant': float(friction['fluid_time_constant']),
        'stop_velocity': float(friction['stop_velocity']),
        'start_velocity': start,
        'element_stiffness': stiffness,
        'element_limit': tuple(float(w) for w in friction['element_limit']),
    }
    return Reading('searched', friction | plain, float(rest_time))


def evaluate(reading: Reading) -> Outcome:
    """Measure all statements under one setting."""
    laboratory = Laboratory(reading, TOLERANCE)
    rows = [measure(laboratory, statement) for statement in STATEMENTS]
    return Outcome(
        reading,
        {row.statement.number: row.holds for row in rows},
        {row.statement.number: row.share for row in rows},
    )
