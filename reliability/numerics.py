"""``python -m reliability numerics``: random rigs, and whether what they do is possible."""

from __future__ import annotations

import json
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import click
import numpy as np

from pneu_rig_ros.cli import output
from pneu_rig_ros.executor import map_tasks, open_executor
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.plant import TOLERANCE, Plant
from reliability import figures
from reliability.balances import Residuals, problems, residuals
from reliability.random_rigs import DURATION, case

SAMPLES, FINE_SAMPLES = 5_000, (200_000, 1_000_000)
"""Of a run, and of one whose integrals are not good enough with so few."""
FINE_TOLERANCE = 1e-9
"""Local error of a run whose steps are so many that their errors add up [-]."""
LIMIT = 2e-3
"""Largest residual of a balance, as a share of the energy moved [-]."""
OVERPRESSURE = 1.0 + LIMIT
"""Largest pressure as a share of the largest possible one [-]."""
HARDEST = 20
HARDEST_FILE = Path(__file__).resolve().parents[1] / 'test' / 'reliability' / 'hardest.json'


class Outcome(NamedTuple):
    """
    What became of a case.

    :param problems: what was impossible, () in a good run
    :param steps: of the integrator, rejected ones with them
    :param seconds: that the run took, at the first try [s]
    :param level: how fine it had to be: 0 as it is, 1 and 2 finer samples, 3 finer steps
    """

    seed: int
    problems: tuple[str, ...]
    residuals: Residuals
    steps: int
    seconds: float
    level: int


def outcome(seed: int, level: int = 0, share: float = 1.0) -> Outcome:
    """
    Simulate a case; look closer when a balance does not hold.

    :param level: where to begin, see :class:`Outcome`
    :param share: of the run that is simulated, from its beginning [-]
    """
    efforts = [(SAMPLES, TOLERANCE), *((samples, TOLERANCE) for samples in FINE_SAMPLES)]
    efforts.append((FINE_SAMPLES[-1], FINE_TOLERANCE))
    tried = first = _run(seed, *efforts[level], share)._replace(level=level)
    while tried.problems and tried.level + 1 < len(efforts):
        closer = tried.level + 1
        tried = _run(seed, *efforts[closer], share)._replace(level=closer)
    return tried._replace(steps=first.steps, seconds=first.seconds)


def _run(seed: int, samples: int, tolerance: float, share: float) -> Outcome:
    configuration, steps = case(seed)
    model, effects = configuration.model, configuration.effects
    # All effects, most of them null: one compiled plant for every case.
    nulls = {name: library.load(name).null for name in library.names()}
    plant = Plant(model, {**nulls, **effects}, tolerance=tolerance)
    start, started = plant.state, time.process_time()
    voltages = np.repeat(steps, samples // len(steps), axis=0)[: round(share * samples)]
    run = plant.run(voltages, DURATION / samples)
    taken = time.process_time() - started
    found = problems(run, model)
    left = Residuals(0.0, 0.0, 0.0, 0.0) if found else residuals(run, start, model, effects)
    counts = plant.counts
    return Outcome(seed, tuple(found or _unbalanced(left)), left,
                   counts['steps'] + counts['rejected'], taken, 0)  # fmt: skip


def _unbalanced(left: Residuals) -> list[str]:
    checks = {
        f'gas: {left.gas:.2g} of the energy is not accounted for': left.gas <= LIMIT,
        f'{left.created:.2g} of the energy is created': left.created <= LIMIT,
        f'friction gives {-left.dissipated:.2g} of the energy': left.dissipated >= -LIMIT,
        f'{left.overpressure:.4g} of the largest possible pressure': left.overpressure
        <= OVERPRESSURE,
    }
    return [text for text, holds in checks.items() if not holds]


def hardest(outcomes: Iterable[Outcome]) -> dict[int, int]:
    """Return seed -> level of the hardest cases: half by steps, half by residuals."""
    by_steps = sorted(outcomes, key=lambda o: o.steps, reverse=True)
    chosen = by_steps[: HARDEST // 2]
    # The finest samples take too long for a test.
    quick = [o for o in by_steps[HARDEST // 2 :] if o.level < 2]
    rest = sorted(quick, key=lambda o: (o.level, o.residuals.gas))
    chosen += rest[-(HARDEST - len(chosen)) :]
    return {o.seed: o.level for o in sorted(chosen, key=lambda o: o.seed)}


def summary(outcomes: list[Outcome]) -> dict[str, Any]:
    """Return the figures of all cases."""
    return {
        'cases': len(outcomes),
        'failures': {o.seed: list(o.problems) for o in outcomes if o.problems},
        'finer_samples': sum(o.level in (1, 2) for o in outcomes),
        'finer_steps': sum(o.level == 3 for o in outcomes),
        'largest_gas_residual': max(o.residuals.gas for o in outcomes),
        'largest_created': max(o.residuals.created for o in outcomes),
        'least_dissipated': min(o.residuals.dissipated for o in outcomes),
        'largest_overpressure': max(o.residuals.overpressure for o in outcomes),
        'median_steps': float(np.median([o.steps for o in outcomes])),
        'most_steps': max(o.steps for o in outcomes),
        'longest_s': round(max(o.seconds for o in outcomes), 2),
        'hardest': hardest(outcomes),
    }


def text(data: dict[str, Any]) -> str:
    """Return the figures as Markdown."""
    rows = {
        'energy of the gas beside enthalpy, heat and work': (data['largest_gas_residual'], LIMIT),
        'energy created, with that of the motion': (data['largest_created'], LIMIT),
        'least energy that friction has taken up': (data['least_dissipated'], -LIMIT),
    }
    table = '\n'.join(
        f'| {name} | {worst:.1e} | {limit:g} |' for name, (worst, limit) in rows.items()
    )
    failures = len(data['failures'])
    return f"""
`make numerics`: {data['cases']:,} random rigs of {DURATION:g} s each, {failures} failures.
Half of the rigs have every parameter within a factor of ten of a shipped cylinder, half
anywhere in its range; any friction law and reading, none to four of the effects that stand for
physics, valves that step to anywhere. In every run all values are finite, the piston is between
the stops, and the pressures are above 0 and at most what compression by the piston makes of supply
pressure (with a leak past the piston, heat from the walls or lagging lines there are other ways
up).

| balance, as a share of the energy moved | worst of all runs | allowed |
| --- | --- | --- |
{table}

{data['finer_samples']} runs vibrate so fast that the integrals of work take up to
{FINE_SAMPLES[-1]:,} samples in place of {SAMPLES:,}. In {data['finer_steps']} more the local
errors of very many steps add up: there the balance holds at a tolerance of {FINE_TOLERANCE:g} in
place of {TOLERANCE:g}. Energies of motion are not balanced where an effect adds forces. The median
run takes {data['median_steps']:.0f} steps, the hardest {data['most_steps']:,}
({data['longest_s']} s). The {HARDEST} hardest are tests, the first fifth of
each run: `test/reliability/hardest.json`."""


@click.command()
@click.option('--count', type=click.IntRange(1), default=10_000, show_default=True, help='of rigs')
@click.option('--first', type=int, default=0, show_default=True, help='seed of the first')
@click.option('--workers', type=click.IntRange(1), help='processes  [default: one a processor]')
@click.option('--keep/--no-keep', default=True, help='write docs/reliability.* and the hardest')
def numerics(count: int, first: int, workers: int | None, keep: bool) -> None:
    """Simulate random rigs; exit code 1 if any does what cannot be."""
    seeds = range(first, first + count)
    with output.step_bar('random rigs', count) as progress, open_executor(workers) as executor:
        outcomes = map_tasks(executor, outcome, seeds, progress=progress)
    data = summary(outcomes)
    rows = [(name.replace('_', ' '), str(value)) for name, value in data.items()]
    output.print_table(output.table(('figure', 'value'), rows))
    if keep:
        HARDEST_FILE.write_text(json.dumps(data['hardest']) + '\n')
        figures.keep('numerics', data, text(data))
    if data['failures']:
        raise SystemExit(1)
