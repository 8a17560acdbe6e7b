"""
``make blind``: trials drawn from a seed, or a part of the matrix for building, and the page.

Answers are kept beside the page, a file for each revision, one line a trial: what is there already
is not run again. The page is written of the drawn trials alone.
"""

import json
from collections.abc import Iterator
from pathlib import Path

import click
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.executor import completed, open_executor
from pneu_rig_ros.records.description import git_revision

from . import foreign_page, foreign_scores, page, scores
from .answers import FOLDER, Answer, carry_out, kept
from .foreign_trials import FOREIGN_PARTS, drawn_foreign
from .fresh import FRESH, FRESH_PARTS, SEED, drawn
from .page_tables import text_of
from .trials import PARTS, Trial, matrix

WORLD = 'foreign_world'
"""All parts of the foreign world; with it, the page of that is written."""
ROOT = Path(__file__).resolve().parents[2]


def answers_to(trials: list[Trial], workers: int, scheduler: str | None) -> Iterator[Answer]:
    """
    Yield the answers to trials.

    Here one trial comes after the other, and its diagnosis has all workers; on a cluster each
    worker has trials of its own.
    """
    with open_executor(workers, scheduler) as executor:
        if scheduler:
            yield from (answer for _, answer in completed(executor, carry_out, trials))
        else:
            yield from (carry_out(trial, executor) for trial in trials)


def run(trials: list[Trial], answers: Iterator[Answer], console: Console, store: Path) -> None:
    """Carry out the trials and append each answer to the file."""
    columns = (
        TextColumn('{task.description}'),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    store.parent.mkdir(parents=True, exist_ok=True)
    with Progress(*columns, console=console) as progress, store.open('a') as file:
        task = progress.add_task('blind trials', total=len(trials))
        for answer in answers:
            file.write(json.dumps(answer) + '\n')
            file.flush()
            progress.update(task, advance=1, description=answer['key'])


def chosen(
    parts: tuple[str, ...], seed: int, hidden: tuple[str, ...], noise: tuple[float, ...]
) -> list[Trial]:
    """Return the trials that all filters let through; an empty one lets all."""
    known = {part for part in parts if part not in (FRESH, WORLD)}
    if WORLD in parts:
        known = known or set(FOREIGN_PARTS)
    trials = [*(drawn(seed) if FRESH in parts else matrix(tuple(sorted(known & set(PARTS)))))]
    trials += drawn_foreign(seed, sorted(known & set(FOREIGN_PARTS)))
    return [
        trial
        for trial in trials
        if (not known or trial.part in known)
        and (not hidden or set(hidden) & set(trial.names))
        and (not noise or trial.noise in noise)
    ]


@click.command()
@click.option(
    '--part',
    'parts',
    multiple=True,
    default=(FRESH,),
    show_default=True,
    type=click.Choice(sorted({FRESH, WORLD, *FRESH_PARTS, *PARTS, *FOREIGN_PARTS})),
    help='fresh: drawn from the seed; with it, another one picks a part of these, but for those '
    'of a foreign world, which are drawn only when named; foreign_world: all of these',
)
@click.option('--seed', default=SEED, show_default=True, help='of what is drawn')
@click.option('--effect', multiple=True, help='effect or section.key that is hidden')
@click.option('--noise', multiple=True, type=float, help='multiple of the noise of the rig')
@click.option('--limit', type=int, help='at most so many trials that are not yet answered')
@click.option('--workers', default=2, show_default=True, help='of each diagnosis')
@click.option('--scheduler', help='of a Dask cluster to use instead, tcp://HOST:PORT')
@click.option('--revision', default=git_revision, help='name of the answers  [default: of git]')
@click.option('--docs', type=click.Path(path_type=Path), default=ROOT / 'docs')
def main(
    parts: tuple[str, ...],
    seed: int,
    effect: tuple[str, ...],
    noise: tuple[float, ...],
    limit: int | None,
    workers: int,
    scheduler: str | None,
    revision: str,
    docs: Path,
) -> None:
    """Run blind trials, then write docs/blind.md, docs/blind.json and the picture."""
    console = Console()
    world = '_foreign' if WORLD in parts else ''
    store = docs / FOLDER / f'{revision}{world}.jsonl'
    wanted = chosen(parts, seed, effect, noise)
    answered = {answer['key'] for answer in kept(store, wanted)}
    trials = [trial for trial in wanted if trial.key not in answered][:limit]
    try:
        run(trials, answers_to(trials, workers, scheduler), console, store)
    except RigError as error:
        raise click.UsageError(str(error)) from None
    if FRESH in parts:  # those for building are told here alone
        page.write_kept(store.parent, docs, revision, seed)
    if world:
        foreign_page.write_kept(store.parent, docs)
    answers = kept(store, wanted)
    figures = scores.figures(answers)
    if world or set(parts) & set(FOREIGN_PARTS):
        figures = foreign_scores.figures(answers)
        console.print(foreign_scores.headline(answers))
        console.print(foreign_scores.by_form(answers))
    for name, figure in figures.items():
        value = text_of(name, figure['value'], 1)
        console.print(f'{name:20s} {value:>8s}  {figure["trials"]} trials')


if __name__ == '__main__':
    main()
