"""
The paper's statements, each measured on simulated strokes.

A statement holds if all its findings hold. Where the text gives words ("nearly unchanged",
"extremely small"), the finding states the number that stands for them. Where a finding compares
dwells or slips of strokes, these are the medians of each. A dwell is a rest of
``analysis.motion``: slower than 1 mm/s for at least 60 ms.

A statement that holds under a single setting only is no property of the model. So each is
measured again under neighbours: the command or the supply pressure 5 % off, other starts along the
stroke, and each unprinted quantity 5 % off.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

from pneu_rig_ros.claims import captions, trends
from pneu_rig_ros.claims.experiments import CYLINDERS, Conditions, Laboratory, Reading
from pneu_rig_ros.claims.findings import Row, Statement
from pneu_rig_ros.claims.friction import dwell_law, estimated_friction
from pneu_rig_ros.claims.trends import STARTS
from pneu_rig_ros.executor import Executor, map_tasks
from pneu_rig_ros.model.parameters import FADES_WHILE_SLIDING, FILM_RESTS_BY_SPEED

_MEASURES = {
    'cylinder 1 rests for seconds and slips; dwells and peaks decrease': captions.cylinder_1,
    'cylinder 2 has shorter dwells and smaller slips': captions.cylinder_2,
    'cylinder 3 has many more, very short, very small cycles': captions.cylinder_3,
    'more airflow: fewer events, shorter stroke': trends.airflow,
    'more supply pressure: shorter stroke and dwells, larger steps': trends.supply,
    'more load: as many cycles, larger slips, slightly shorter stroke': trends.load,
    'further start: longer first dwell, later dwells and slips unchanged': trends.initial_position,
    'RLG misses the cycles; Eq. 16 persists and attenuates': captions.constant_static_friction,
    'static friction grows with dwell time along Eq. 16': dwell_law,
    'Eq. 2 gives back the friction of the model': estimated_friction,
    'some sticking phases of cylinder 2 creep, in general none': captions.creep,
    'intermediate airflow: shorter dwells, larger slips': trends.intermediate_airflow,
    'pronounced steps at 3 and 4 bar': trends.low_supply,
    'RLG gets the first cycle, not the later ones': captions.first_cycles,
    'dwells, pressure and friction peaks vary gradually, unlike with RLG': captions.evolution,
    'each valve can deliver up to 720 L/min': trends.valve_flow,
    'the guide has 10-15 % of the friction at any speed': trends.guide_friction,
}
STATEMENTS = tuple(
    Statement(number, text, measure)
    for number, (text, measure) in enumerate(_MEASURES.items(), start=1)
)
"""All statements: 1-10 the main ones, 11-17 details."""


def measure(laboratory: Laboratory, statement: Statement) -> Row:
    """Measure one statement."""
    return Row(statement, tuple(statement.measure(laboratory)))


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
    speeds = ['stop_velocity', 'start_velocity']
    keys = ['fluid_time_constant', 'element_stiffness', *speeds, 'element_limit']
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
