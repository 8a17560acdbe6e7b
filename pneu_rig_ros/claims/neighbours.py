"""
Settings next to one, under which its statements should hold as well.

A statement that holds under a single setting only is no property of the model. So each is
measured again with the command or the supply pressure 5 % off, from other starts along the
stroke, and with each unprinted quantity 5 % off.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

from pneu_rig_ros.claims.experiments import CYLINDERS, Conditions, Laboratory, Reading
from pneu_rig_ros.claims.statements import STATEMENTS, measure
from pneu_rig_ros.claims.trends import STARTS
from pneu_rig_ros.executor import Executor, map_tasks
from pneu_rig_ros.model.parameters import FADES_WHILE_SLIDING, FILM_RESTS_BY_SPEED

STEP = 0.05
"""How far a neighbour is off, as a share [-]."""


class Neighbour(NamedTuple):
    """
    A setting next to one.

    :param name: what is different
    :param reading: what the paper does not print
    :param conditions: how the experiments are carried out
    """

    name: str
    reading: Reading
    conditions: Conditions = Conditions()


def neighbours(reading: Reading) -> Iterator[Neighbour]:
    """Yield the neighbours of a reading."""
    for sign in (1.0, -1.0):
        factor, off = 1.0 + sign * STEP, f'{sign * STEP:+.0%}'
        yield Neighbour(f'u {off}', reading, Conditions(command=factor))
        yield Neighbour(f'supply {off}', reading, Conditions(supply=factor))
        for section, key in varied(reading):
            moved = {name: _moved(reading, name, section, key, factor) for name in CYLINDERS}
            yield Neighbour(f'{key} {off}', Reading(reading.name, reading.common, moved))
    for start in STARTS:
        yield Neighbour(f'start at {start:.0%}', reading, Conditions(start=start))


def varied(reading: Reading) -> list[tuple[str, str]]:
    """Return section and field of the unprinted quantities that a reading uses."""
    laws = [reading.model(name).friction for name in CYLINDERS]
    keys = ['fluid_time_constant', 'element_stiffness', 'stop_velocity', 'start_velocity']
    if any(law.element_limit for law in laws):
        keys.append('element_limit')
    if any(law.static_friction_reading == FADES_WHILE_SLIDING for law in laws):
        keys.append('memory_time')
    if any(law.film_rest_reading == FILM_RESTS_BY_SPEED for law in laws):
        keys.append('film_rest_velocity')
    used = [key for key in keys if any(getattr(law, key) for law in laws)]
    return [('operation', 'rest_time'), *(('friction', key) for key in used)]


def _moved(
    reading: Reading, cylinder: str, section: str, key: str, factor: float
) -> dict[str, Mapping[str, object]]:
    """Return what differs for a cylinder, with one quantity multiplied by a factor."""
    own = dict(reading.single.get(cylinder, {}))
    value = getattr(getattr(reading.model(cylinder), section), key)
    scaled = tuple(factor * item for item in value) if isinstance(value, tuple) else factor * value
    changes = {**own.get(section, {}), key: scaled}
    if key == 'stop_velocity':  # never above the start velocity
        law = reading.model(cylinder).friction
        changes['start_velocity'] = max(law.start_velocity, scaled)
    if key == 'start_velocity':
        changes[key] = max(scaled, reading.model(cylinder).friction.stop_velocity)
    return {**own, section: changes}


def failures(
    reading: Reading, executor: Executor, progress: Callable[[int], None] = lambda _: None
) -> dict[int, list[str]]:
    """
    Return number of a statement -> names of the neighbours under which it does not hold.

    :param executor: where neighbours are measured
    :param progress: callback(number of neighbours measured)
    """
    every = list(neighbours(reading))
    failed = map_tasks(executor, failing, every, progress=progress)
    return {
        statement.number: [
            neighbour.name
            for neighbour, numbers in zip(every, failed, strict=True)
            if statement.number in numbers
        ]
        for statement in STATEMENTS
    }


def failing(neighbour: Neighbour) -> set[int]:
    """Return the numbers of the statements that do not hold under a neighbour."""
    laboratory = Laboratory(neighbour.reading, neighbour.conditions)
    rows = [measure(laboratory, statement) for statement in STATEMENTS]
    return {row.statement.number for row in rows if not row.holds}
