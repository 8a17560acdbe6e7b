"""What is told of the candidates, also where the gains of the sensors are fitted along."""

import numpy as np

from pneu_rig_ros.gap.answer import MOST_CANDIDATES, indistinguishable, ranked
from pneu_rig_ros.gap.candidates import effect_candidate
from pneu_rig_ros.gap.diagnosis import Diagnosis
from pneu_rig_ros.gap.evidence import Evidence
from pneu_rig_ros.gap.fitting import Fit
from pneu_rig_ros.gap.prediction import Mode
from pneu_rig_ros.gap.scoring import Scored
from pneu_rig_ros.gap.screening import Screened
from pneu_rig_ros.gap.selection import Search
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.rig import load_configuration

NOTHING = Evidence([], np.random.default_rng(0))
CHAMBERS = ('chamber_leak', 'cross_piston_leak', 'wall_heat_transfer')
CYCLES = ('inclination', 'load_spring')


def searched(diagnosis: Diagnosis, mode: Mode, names: tuple[str, ...]) -> Search:
    """Return a search that has fitted some effects, the first the best, and screened all."""
    base = diagnosis.uncalibrated()
    search = Search(diagnosis.given, NOTHING, NOTHING, (mode,), print, base)
    search.level = 0.1
    for index, name in enumerate(names):
        part, cost = effect_candidate(name), 0.3 + 0.01 * index
        fit = Fit(base.plus(part, part.starts[0]), cost, np.ones(1))
        search.scored.append(Scored(fit, cost))
    every = [name for name in library.names() if not library.load(name).describes]
    search.screened = [
        Screened(part, part.starts[0], 1.0) for part in map(effect_candidate, every)
    ]
    return search


def diagnosis() -> Diagnosis:
    """Return a diagnosis of a rig whose sensors may have errors of gain, in two searches."""
    found = Diagnosis(load_configuration('cylinder_1'), NOTHING, NOTHING)
    assert found.uncalibrated().parts
    for mode, names in ((Mode.CHAMBERS, CHAMBERS), (Mode.CYCLES, CYCLES)):
        found.searches[mode], found.costs[mode] = searched(found, mode, names), 2.0
    return found


def test_searches_take_turns_and_what_was_fitted_stands_first() -> None:
    rows = ranked(diagnosis())
    assert [row['names'] for row in rows[:5]] == [
        ['chamber_leak'], ['inclination'], ['cross_piston_leak'], ['load_spring'],
        ['wall_heat_transfer'],
    ]  # fmt: skip
    assert [row['stage'] for row in rows] == ['fitted'] * 5 + ['screened'] * 15
    assert len({tuple(row['names']) for row in rows}) == len(rows) == MOST_CANDIDATES


def test_gains_of_the_sensors_are_no_rival_and_hide_none() -> None:
    unexplained = diagnosis()
    unexplained.unexplained = Mode.CYCLES
    assert list(unexplained.rivals) == list(CYCLES)
    explained = diagnosis()
    search = explained.searches[Mode.CYCLES]
    search.best = search.scored[0]
    assert list(explained.rivals) == list(CYCLES)
    assert indistinguishable(explained) == [list(CYCLES)]
