"""``python -m reliability scale``."""

from __future__ import annotations

import statistics
from collections.abc import Iterable
from typing import Any

import click

from benchmarks.__main__ import machine
from pneu_rig_ros.cli import output
from pneu_rig_ros.executor import open_executor
from reliability import figures
from reliability.scale import costs
from reliability.scale.projection import Cost, efficiency, most_cores, wall_time
from reliability.scale.proofs import independence, killed_worker
from reliability.scale.words import words

WORKERS = (2, 3)
MANY_TRIALS, MANY_CORES = 1_000_000, 1_000
"""Of the projection."""


@click.command()
@click.option('--tasks', type=click.IntRange(4), default=60, show_default=True,
              help='of each proof; a task takes about a tenth of a second')  # fmt: skip
@click.option('--pairs', type=click.IntRange(1), default=7, show_default=True,
              help='of measurements, of which the median counts')  # fmt: skip
@click.option('--trials', type=click.IntRange(2), default=8, show_default=True,
              help='blind trials that are timed; one takes from seconds to minutes')  # fmt: skip
def scale(tasks: int, pairs: int, trials: int) -> None:
    """Share work out to processes: same bits, a worker killed, speed-up, cost of a trial."""
    found: dict[str, Any] = {'machine': machine()}
    with output.step_bar('same bits', (len(WORKERS) + 1) * tasks) as progress:
        found['independence'] = independence(tasks, WORKERS, progress)
    with output.step_bar('a worker is killed', tasks) as progress, open_executor(2) as two:
        found['killed_worker'] = killed_worker(tasks, two, progress)
    with output.step_bar('batch', pairs) as progress:
        found['batch'] = _ratios(_told(costs.batch_pairs(pairs), progress))
    found['start_up'] = costs.start_up()
    found['way'] = costs.way()
    found['compile_s'] = costs.compilation()
    with open_executor(2) as two:
        with output.step_bar('two processes', pairs) as progress:
            found['processes'] = _ratios(_told(costs.process_pairs(pairs, tasks, two), progress))
        found['machine_ratio'] = costs.machine_ratio(two)
        with output.step_bar('trials', trials) as progress:
            found['trials'] = costs.trials(trials, two, progress)
    found['projection'] = _projection(found)
    figures.keep('scale', found, words(found))
    output.print_values({'written': 'docs/reliability.md, docs/reliability.json'})
    if not _holds(found):
        raise click.ClickException('not all that is wanted was so; see docs/reliability.md')


def _told(pairs: Iterable[costs.Pair], progress: Any) -> list[costs.Pair]:
    done = []
    for pair in pairs:
        done.append(pair)
        progress(len(done))
    return done


def _ratios(pairs: list[costs.Pair]) -> dict[str, Any]:
    ratios = [pair.ratio for pair in pairs]
    return {
        'ratio': statistics.median(ratios),
        'least': min(ratios),
        'most': max(ratios),
        'one_s': statistics.median(pair.one for pair in pairs),
        'two_s': statistics.median(pair.two for pair in pairs),
    }


def _projection(found: dict[str, Any]) -> dict[str, Any]:
    """Return what the measured costs say of these trials, and of many on many cores."""
    trial, way, start = found['trials'], found['way'], found['start_up']
    cost = Cost(
        trial['mean_s'], trial['longest_s'], way['latency_s'], way['overhead_s'],
        trial['answer_bytes'] * 1e-6 * way['megabyte_s'], start['start_s'] + start['load_s'],
        found['compile_s'],
    )  # fmt: skip
    warm = cost._replace(start=0.0, compilation=0.0)
    return {
        'cost': cost._asdict(),
        'these_trials_s': wall_time(warm, trial['count'], 2),
        'trials': MANY_TRIALS,
        'cores': MANY_CORES,
        'hours': wall_time(cost, MANY_TRIALS, MANY_CORES) / 3600.0,
        'efficiency': efficiency(cost, MANY_TRIALS, MANY_CORES),
        'most_cores': most_cores(cost),
    }


def _holds(found: dict[str, Any]) -> bool:
    killed = found['killed_worker']
    return (
        all(found['independence']['same_bits'].values())
        and killed['same_bits']
        and set(killed['killed_while_doing']) <= set(killed['done_again'])
        and len(killed['done_again']) <= 2
    )
