"""`pneu-rig gap`: hide an effect in the rig, find it, close the gap, reveal what it was."""

from __future__ import annotations

import contextlib
import secrets
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.cli import options, output
from pneu_rig_ros.errors import RigError

if TYPE_CHECKING:
    from pneu_rig_ros.analysis.metrics import SignalGap
    from pneu_rig_ros.scenarios.gap import HiddenEffect, Outcome

SEEDS = 1000
"""A seed that is drawn is below this number."""
CLEAR = 1.5
"""RMSE in multiples of the noise above which the part that exceeds the noise is accurate."""
GAPS = ('signal', '>before', '>after', '>noise of two runs', 'unit', '>gap closed')


@options.command(
    'pneu-rig gap',
    'pneu-rig gap --seed 7 --out runs/seven',
    'pneu-rig gap --effect inclination',
)
@options.seed_option(help='seed of the effect and of the noise  [default: random]')
@options.out_directory(help='directory to create  [default: runs/DATE_gap]')
@click.option(
    '--effect',
    metavar='NAME',
    help='hide this effect, one of pneu-rig effects  [default: drawn from the seed]',
)
@options.output_options
def gap(
    seed: int | None, out: Path | None, effect: str | None, as_json: bool, quiet: bool
) -> None:
    """
    Hide an effect in the rig, find it, close the gap.

    Draws an effect and hides it in the plant, records experiments over ROS 2 into bags, and
    diagnoses them with a model that lacks the effect. Then records a held-out experiment again
    with this model and with the improved one. The result is a picture, the gap in numbers, and
    what was hidden.

    The effect is one of 14 of the 41 effects: those that show well above the noise in runs as
    short as these. --effect hides others too.
    """
    from pneu_rig_ros.demo import prepare_environment
    from pneu_rig_ros.scenarios.gap import draw

    seed = secrets.randbelow(SEEDS) if seed is None else seed
    hidden = draw(seed, effect)
    prepare_environment()
    options.load_ros()
    path = options.bag_path(out, 'gap')
    if not (as_json or quiet):
        _introduce(hidden, seed)

    from pneu_rig_ros.scenarios.gap import close_gap

    with _whole(path) as folder, output.stage_bar(quiet) as progress:
        outcome = close_gap(folder, hidden, seed, progress)
    if as_json:
        output.print_json(to_dict(outcome, hidden, seed, path))
    elif not quiet:
        _show(outcome, hidden, path)


@contextlib.contextmanager
def _whole(path: Path) -> Iterator[Path]:
    """Yield a directory to work in that becomes `path` on success, and is removed otherwise."""
    unfinished = path.with_name(f'.{path.name}.unfinished')
    shutil.rmtree(unfinished, ignore_errors=True)
    try:
        with options.directory(path.parent):
            try:
                unfinished.mkdir()
                yield unfinished
                unfinished.rename(path)
            finally:
                shutil.rmtree(unfinished, ignore_errors=True)
    except OSError as error:
        raise RigError(f'--out {path}: {error.strerror}') from error


def _introduce(hidden: HiddenEffect, seed: int) -> None:
    from pneu_rig_ros.scenarios.gap import DRAWN

    sensors = 'noise and 12 bit as on the rig, but no gain errors (accuracy class 0):\n'
    output.print_values(
        {
            'rig': f'{hidden.model.name}, with a hidden effect that its model lacks',
            'drawn from': f'{len(DRAWN)} effects, seed {seed}',
            'sensors': sensors + 'these would be fitted along with the missing effect',
        }
    )


def to_dict(outcome: Outcome, hidden: HiddenEffect, seed: int, path: Path) -> dict[str, Any]:
    """Return the result as a JSON-compatible dict; gaps are RMSE in the unit of their signal."""
    gaps = {
        name: {
            'before': before.rmse,
            'after': outcome.after[name].rmse,
            'noise': before.noise,
            'unit': before.unit,
        }
        for name, before in outcome.before.items()
    }
    return {
        'seed': seed,
        'hidden': hidden.effect,
        'gap': gaps,
        'directory': str(path),
        'diagnosis': outcome.answer,
    }


def _show(outcome: Outcome, hidden: HiddenEffect, path: Path) -> None:
    """Print what was found, the gap, the files, and what was hidden."""
    from pneu_rig_ros.report import diagnosis_rows as rows

    terminal = output.console()
    terminal.print()
    terminal.print(outcome.answer['sentence'], style='bold')
    terminal.print()
    terminal.print('RMSE on a held-out run, recorded again with each model')
    output.print_table(GAPS, _gap_rows(outcome))
    terminal.print()
    output.print_values(
        {
            'diagnosis': rows.cut_text(outcome.answer),
            'report': path / 'answer' / 'report.html',
            'improved model': path / 'answer' / 'improved.yaml',
            'bags': path / 'measured',
            'picture': path / 'gap.png',
        }
    )
    terminal.print()
    added = rows.added_rows(outcome.answer)
    found = [f'{name} {value} {unit}'.strip() for name, _, value, _, unit in added]
    output.print_values(
        {
            'hidden': f'{hidden.effect}: {hidden.text}',
            'identified': '; '.join(found) or 'nothing',
        }
    )


def _gap_rows(outcome: Outcome) -> Iterator[tuple[str, ...]]:
    """Yield the rows of the table of gaps."""
    from pneu_rig_ros.report.diagnosis_rows import number
    from pneu_rig_ros.report.figure import display, plain_name

    for name, before in outcome.before.items():
        after = outcome.after[name]
        unit, scale = display(before.unit)
        values = (before.rmse, after.rmse, before.noise or 0.0)
        texts = (number(scale * value) for value in values)
        yield plain_name(name), *texts, unit, _closed(before, after)


def _closed(before: SignalGap, after: SignalGap) -> str:
    """Return the part of the gap above the noise that is closed, if it was clear of the noise."""
    if before.noise is not None and before.rmse <= CLEAR * before.noise:
        return 'near noise'
    return f'{1.0 - after.above_noise / before.above_noise:.0%}'
