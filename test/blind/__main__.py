"""
``make blind``: the whole matrix, or a part of it, and the page about it.

Answers are kept beside the page, in ``blind_answers.jsonl``, one line a trial: what is there
already is not run again, on whatever machine. ``--fresh`` forgets them.
"""

import json
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
from pneu_rig_ros.executor import Executor, executor

from . import page, scores
from .answers import KEPT, carry_out, kept
from .hidden import STRENGTHS
from .trials import NOISES, PARTS, Trial, matrix

ROOT = Path(__file__).resolve().parents[2]


def run(trials: list[Trial], somewhere: Executor, console: Console, store: Path) -> None:
    """Carry out the trials and append each answer to the file."""
    columns = (TextColumn('{task.description}'), BarColumn(), MofNCompleteColumn(),
               TimeElapsedColumn(), TimeRemainingColumn())  # fmt: skip
    with Progress(*columns, console=console) as progress, store.open('a') as file:
        task = progress.add_task('blind trials', total=len(trials))
        for _, answer in somewhere.completed(carry_out, trials):
            file.write(json.dumps(answer) + '\n')
            file.flush()
            progress.update(task, advance=1, description=answer['key'])


def chosen(
    part: tuple[str, ...],
    cylinder: tuple[str, ...],
    noise: tuple[float, ...],
    strength: tuple[str, ...],
    effect: tuple[str, ...],
) -> list[Trial]:
    """Return the trials of the matrix that all filters let through; an empty one lets all."""
    return [
        trial for trial in matrix(part or PARTS)
        if (not cylinder or trial.cylinder[-1] in cylinder)
        and (not noise or trial.noise in noise)
        and (not strength or trial.strength in strength)
        and (not effect or set(effect) & set(trial.names))
    ]  # fmt: skip


@click.command()
@click.option('--part', multiple=True, type=click.Choice(PARTS))
@click.option('--cylinder', multiple=True, type=click.Choice(['1', '2', '3']))
@click.option('--noise', multiple=True, type=click.Choice([f'{n:g}' for n in NOISES]))
@click.option('--strength', multiple=True, type=click.Choice(STRENGTHS))
@click.option('--effect', multiple=True, help='effect or section.key that is hidden')
@click.option('--limit', type=int, help='at most so many trials that are not yet answered')
@click.option('--workers', default=2, show_default=True)
@click.option('--scheduler', help='of a Dask cluster that does it instead, tcp://HOST:PORT')
@click.option('--fresh', is_flag=True, help='forget the answers given so far')
@click.option('--docs', type=click.Path(path_type=Path), default=ROOT / 'docs')
def main(
    part: tuple[str, ...],
    cylinder: tuple[str, ...],
    noise: tuple[str, ...],
    strength: tuple[str, ...],
    effect: tuple[str, ...],
    limit: int | None,
    workers: int,
    scheduler: str | None,
    fresh: bool,
    docs: Path,
) -> None:
    """Run blind trials, then write docs/blind.md, docs/blind.json and the picture."""
    console = Console()
    store = docs / KEPT
    if fresh:
        store.unlink(missing_ok=True)
    answered = {answer['key'] for answer in kept(store)}
    wanted = chosen(part, cylinder, tuple(map(float, noise)), strength, effect)
    trials = [trial for trial in wanted if trial.key not in answered][:limit]
    try:
        with executor(workers, scheduler) as somewhere:
            run(trials, somewhere, console, store)
    except RigError as error:
        raise click.UsageError(str(error)) from None
    answers = kept(store)
    page.write(answers, docs)
    for name, figure in scores.figures(answers).items():
        console.print(
            f'{name:20s} {page.percent(figure["value"], 1):>8s}  {figure["trials"]} trials'
        )


if __name__ == '__main__':
    main()
