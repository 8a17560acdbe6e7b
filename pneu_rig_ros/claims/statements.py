"""
The paper's ten statements, each measured on simulated strokes.

A statement holds when each of its findings does. What the text gives in words ("nearly
unchanged", "extremely small") is put into a number in the finding itself, so that it can be read.
Where a finding compares dwells or slips of strokes, these are the medians of each.
"""

from dataclasses import replace

import numpy as np

from pneu_rig_ros.claims.dwell_law import dwell_law
from pneu_rig_ros.claims.estimation import estimated_friction
from pneu_rig_ros.claims.experiments import CAPTIONS, CYLINDERS, Experiment, Laboratory
from pneu_rig_ros.claims.findings import (
    Finding,
    Row,
    Statement,
    at_least,
    at_most,
    falls,
    falls_throughout,
    grows,
    numbers,
    rises_throughout,
    unchanged,
)
from pneu_rig_ros.claims.measures import (
    creep_while_sticking,
    dwells,
    middle,
    pressure_drops,
    slips,
    stick_slip_reach,
    stuck_share,
)

RLG, DWELL = 'revised_lugre', 'revised_lugre_dwell'

COMMANDS = {
    'cylinder_1': (0.28, 0.29, 0.32, 0.38),
    'cylinder_2': (0.34, 0.42, 0.60, 0.80),
    'cylinder_3': (0.32, 0.40, 0.45, 0.50),
}
"""
Commands of Fig. 7 [V]. The text prints only 0.28-0.29 V for cylinder 1 and those of the captions;
the largest ones here shorten the stroke to a half (cylinder 1 and 3) and a third (cylinder 2).
"""
SUPPLIES = (4e5, 5e5, 6e5, 7e5, 8e5)
"""3 to 7 bar gauge, as absolute pressures [Pa] (Fig. 8)."""
LOADS = (0.2, 1.9, 3.6, 5.3)
"""[kg] (Fig. 9)."""
LOAD_COMMAND = 0.30
"""[V] (caption of Fig. 9)."""
STARTS = (0.0, 0.05, 0.1)
"""
Initial positions of Fig. 10, as shares of the stroke further than that of Fig. 4-6 [-]; the text
prints none.
"""


def cylinder_1(laboratory: Laboratory) -> list[Finding]:
    """Statement 1 (Fig. 4)."""
    stroke = laboratory.captions()[0]
    peaks, waits = stroke.column('peak_friction'), stroke.column('dwell')
    first = float(peaks[0]) if len(peaks) else np.nan
    longest = float(waits.max()) if len(waits) else 0.0
    shorter = at_most(float(waits[1:].max()), float(waits[0])) if len(waits) > 1 else np.nan
    drops = pressure_drops(stroke)
    return [
        Finding(
            'first friction peak 15 N within 10 %',
            f'{first:.1f} N', 1.0 - abs(first - 15.0) / 1.5,
        ),
        Finding('at least four cycles', f'{stroke.count}', at_least(stroke.count, 4)),
        Finding(
            'dwell of several seconds (at least 2 s)',
            f'{longest:.2f} s', at_least(longest, 2.0),
        ),
        Finding(
            'driving pressure drops in at least 90 % of the slips',
            f'{drops:.0%}', at_least(drops, 0.9),
        ),
        Finding('later dwells shorter than the first', numbers(waits) + ' s', shorter),
        Finding('peaks progressively smaller', numbers(peaks, '.1f') + ' N', falls(peaks[1:])),
    ]  # fmt: skip


def cylinder_2(laboratory: Laboratory) -> list[Finding]:
    """Statement 2 (Fig. 5)."""
    one, two, _ = laboratory.captions()
    waits = [middle(dwells(stroke)) for stroke in (one, two)]
    steps = [1e3 * middle(slips(stroke)) for stroke in (one, two)]
    creep = 1e3 * creep_while_sticking(two)
    return [
        Finding('stick-slip, at least five cycles', f'{two.count}', at_least(two.count, 5)),
        Finding(
            'median dwell shorter than of cylinder 1',
            numbers(waits) + ' s',
            at_most(*waits[::-1]),
        ),
        Finding(
            'median slip smaller than of cylinder 1',
            numbers(steps) + ' mm',
            at_most(*steps[::-1]),
        ),
        Finding(
            'creep while sticking, over 0.1 mm', numbers([creep]) + ' mm', at_least(creep, 0.1)
        ),
    ]


def cylinder_3(laboratory: Laboratory) -> list[Finding]:
    """Statement 3 (Fig. 6)."""
    one, two, three = laboratory.captions()
    counts = [stroke.count for stroke in (one, two, three)]
    waits = [middle(dwells(stroke)) for stroke in (two, three)]
    steps = [1e3 * middle(slips(stroke)) for stroke in (two, three)]
    return [
        Finding(
            'at least twice the cycles of cylinder 1 and 2',
            numbers(counts, 'd'), at_least(counts[2], 2 * max(1, *counts[:2])),
        ),
        Finding(
            'median dwell very short (under half of cylinder 2)',
            numbers(waits) + ' s', at_most(waits[1], 0.5 * waits[0]),
        ),
        Finding(
            'median slip extremely small (under a quarter of cylinder 2)',
            numbers(steps) + ' mm', at_most(steps[1], 0.25 * steps[0]),
        ),
    ]  # fmt: skip


def fewer(counts: list[int]) -> float:
    """Return the margin by which the last count is below the first [-]."""
    return (counts[0] - 1 - counts[-1]) / max(counts[0], 1)


def airflow(laboratory: Laboratory) -> list[Finding]:
    """Statement 4 (Fig. 7)."""
    findings = []
    for name in CYLINDERS:
        runs = laboratory.perform_all(replace(CAPTIONS[name], u=u) for u in COMMANDS[name])
        counts, times = [run.count for run in runs], [run.time for run in runs]
        findings += [
            Finding(f'{name}: fewer events', numbers(counts, 'd'), fewer(counts)),
            Finding(f'{name}: shorter', numbers(times, '.1f') + ' s', falls_throughout(times)),
        ]
        top = runs[-1]
        if name == 'cylinder_3':
            steps = Finding(f'{name}: small steps remain', f'{top.count}', at_least(top.count, 5))
        else:
            stuck = stuck_share(top)
            steps = Finding(
                f'{name}: nearly continuous (stuck under 10 % of the time)',
                f'{stuck:.0%}', at_most(stuck, 0.1),
            )  # fmt: skip
        findings.append(steps)
    return findings


def supply(laboratory: Laboratory) -> list[Finding]:
    """Statement 5 (Fig. 8)."""
    findings = []
    for name in CYLINDERS:
        runs = laboratory.perform_all(replace(CAPTIONS[name], supply_pressure=p) for p in SUPPLIES)
        times, waits = [run.time for run in runs], [middle(dwells(run)) for run in runs]
        steps = [1e3 * middle(slips(run)) for run in runs]
        # nothing may stick any more at the highest pressure, but something must at the lowest
        last = waits[-1] if np.isfinite(waits[-1]) else 0.0
        shorter = at_most(last, waits[0])
        findings += [
            Finding(f'{name}: shorter', numbers(times, '.1f') + ' s', falls_throughout(times)),
            Finding(f'{name}: shorter dwells', numbers(waits) + ' s', shorter),
            Finding(f'{name}: larger steps', numbers(steps) + ' mm', grows(steps)),
        ]
    kept = [run.count for run in runs[-2:]]
    says = 'cylinder_3: steps remain at 6 and 7 bar'
    return [*findings, Finding(says, numbers(kept, 'd'), at_least(min(kept), 5))]


def load(laboratory: Laboratory) -> list[Finding]:
    """Statement 6 (Fig. 9): cylinder 1 at 0.30 V."""
    point = replace(CAPTIONS['cylinder_1'], u=LOAD_COMMAND)
    runs = laboratory.perform_all(replace(point, load_mass=mass) for mass in LOADS)
    counts, times = [run.count for run in runs], [run.time for run in runs]
    steps = [1e3 * middle(slips(run)) for run in runs]
    few, spread = max(1, round(0.25 * counts[0])), max(counts) - min(counts)
    change = times[-1] / times[0] - 1.0
    return [
        Finding(
            f'cycles nearly unchanged (within {few})',
            numbers(counts, 'd'), at_most(spread, few) if min(counts) >= 2 else np.nan,
        ),
        Finding('larger slips', numbers(steps, '.1f') + ' mm', at_least(steps[-1], steps[0])),
        Finding(
            'stroke slightly shorter (by at most 20 %)',
            numbers(times, '.2f') + ' s', min(0.2 + change, -change) / 0.2,
        ),
    ]  # fmt: skip


def initial_position(laboratory: Laboratory) -> list[Finding]:
    """Statement 7 (Fig. 10)."""
    findings = []
    for name in CYLINDERS:
        runs = laboratory.perform_all(starts(laboratory, name))
        firsts = [run.cycles[0].dwell if run.cycles else np.nan for run in runs]
        later = {
            'cycles': ([float(run.count) for run in runs], ''),
            'dwells': ([middle(dwells(run)) for run in runs], ' s'),
            'slips': ([1e3 * middle(slips(run)) for run in runs], ' mm'),
        }
        longer = rises_throughout(firsts)
        findings.append(Finding(f'{name}: longer first dwell', numbers(firsts) + ' s', longer))
        findings += [
            Finding(
                f'{name}: {what} about unchanged (within 30 %)',
                numbers(values, '.3g') + unit,
                unchanged(values, 0.3),
            )
            for what, (values, unit) in later.items()
        ]
    return findings


def starts(laboratory: Laboratory, name: str) -> list[Experiment]:
    """Return the experiments of Fig. 10 with a cylinder."""
    first = laboratory.perform(CAPTIONS[name])
    places = [first.start + share * first.plant.model.cylinder.stroke for share in STARTS]
    return [replace(CAPTIONS[name], initial_position=place) for place in places]


def constant_static_friction(laboratory: Laboratory) -> list[Finding]:
    """Statement 8 (Fig. 11-13): RLG against dwell-dependent static friction."""
    findings = []
    constant, dwelling = laboratory.captions(RLG), laboratory.captions(DWELL)
    for old, new in zip(constant, dwelling, strict=True):
        name = old.experiment.cylinder
        gap = abs(old.count - new.count) / max(new.count, 1)
        persists = stick_slip_reach(new)
        findings += [
            Finding(
                f'{name}: RLG has another number of cycles (by over a quarter)',
                f'{old.count} against {new.count}', at_least(gap, 0.25),
            ),
            Finding(
                f'{name}: with Eq. 16 stick-slip persists to 80 % of the stroke',
                f'{persists:.0%}', at_least(persists, 0.8),
            ),
            Finding(
                f'{name}: and attenuates (falling peaks after the first, as in 1)',
                numbers(new.column('peak_friction'), '.1f') + ' N',
                falls(new.column('peak_friction', first=1)),
            ),
        ]  # fmt: skip
    return findings


STATEMENTS = (
    Statement(1, 'cylinder 1 sticks for seconds and slips; dwells and peaks decrease', cylinder_1),
    Statement(2, 'cylinder 2 has shorter dwells, smaller slips, some creep', cylinder_2),
    Statement(3, 'cylinder 3 has many more, very short, very small cycles', cylinder_3),
    Statement(4, 'more airflow: fewer events, shorter stroke', airflow),
    Statement(5, 'more supply pressure: shorter stroke and dwells, larger steps', supply),
    Statement(6, 'more load: as many cycles, larger slips, slightly shorter stroke', load),
    Statement(7, 'further start: longer first dwell, later cycles unchanged', initial_position),
    Statement(
        8, 'RLG misses the cycles; Eq. 16 persists and attenuates', constant_static_friction
    ),
    Statement(9, 'static friction grows with dwell time along Eq. 16', dwell_law),
    Statement(10, 'Eq. 2 gives back the friction of the model', estimated_friction),
)
"""All statements, in the order of the notes."""


def measure(laboratory: Laboratory, statement: Statement) -> Row:
    """Measure one statement."""
    return Row(statement, tuple(statement.measure(laboratory)))
