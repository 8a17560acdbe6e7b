"""Commands that find what a model lacks: diagnose and gap."""

from __future__ import annotations

import contextlib
import secrets
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.cli import options, output
from pneu_rig_ros.errors import RigError

if TYPE_CHECKING:
    from pneu_rig_ros.analysis.metrics import SignalGap
    from pneu_rig_ros.scenarios.gap import HiddenEffect, Outcome

MOST_RANKED = 8
"""Candidates that are printed."""
MOST_MISSING = 3
"""Missing keys and signals of a closed balance that are printed."""
MOST_NAMED = 3
"""Recordings that are named beside a note."""
COMPARING, DRAWING = 0.96, 0.97
"""Fractions of the work at which models are compared, and at which the report is drawn [-]."""

OF_BALANCES = 'the balances of mass and force; to the RMSE, slips at another time add'
"""What the gap is of, where it is not of simulated cycles."""

SEEDS = 1000
"""A seed that is drawn is below this number."""
CLEAR = 1.5
"""RMSE in multiples of the noise above which the part that exceeds the noise is accurate."""

GAPS = ('signal', '>before', '>after', '>noise of two runs', 'unit', '>gap closed')
RANKING = ('candidate', 'kind', 'stage', '>remaining excess', '>probability', '')


@options.command(
    'pneu-rig diagnose runs/a runs/b runs/c --model cylinder_1 --out answer',
    'pneu-rig diagnose runs/a runs/b --verify runs/c --model rig.yaml --out answer',
    'pneu-rig diagnose daq_*.csv --map map.yaml --model rig.yaml --out answer',
    'pneu-rig diagnose bench_*.csv --map map.yaml --model chambers.yaml --out answer',
    cls=options.VariadicOptionCommand,
    after='Then:\n'
    '  ros2 run pneu_rig_ros plant --ros-args -p cylinder:=answer/improved.yaml\n'
    '\b\nThe conditions of a bag are in its conditions.yaml, those of daq.csv beside it in\n'
    'daq.conditions.yaml:\n'
    '  supply_pressure: 4 bar gauge\n'
    '  load_mass: 0.2 kg\n',
)
@click.argument('bags', metavar='BAG...', nargs=-1, required=True, type=options.PATH)
@click.option('--model', required=True, metavar='NAME|FILE', help='a cylinder, or a YAML file')
@click.option(
    '--verify',
    multiple=True,
    type=options.PATH,
    metavar='BAG...',
    help='held-out bags for validation, up to the next option'
    '  [default: every third BAG; of two the second; of one its last third]',
)
@options.map_option(help='columns, signals and units of BAGs that are text tables (see import)')
@options.out_directory(
    required=True, help='for diagnosis.json, improved.yaml, report.html; new or empty'
)
@options.seed_option(default=0, show_default=True, help='seed of the propagated sensor noise')
@click.option(
    '--without',
    multiple=True,
    metavar='EFFECT',
    help='exclude an effect from the candidates; repeatable',
)
@options.workers_options()
@options.output_options
def diagnose(
    bags: Sequence[Path],
    out: Path,
    workers: int | None,
    scheduler: str | None,
    **settings: Any,
) -> None:
    """
    Find the missing effect or wrong parameter of a model.

    Localises the residuals that exceed the noise, selects the missing effect or wrong parameter
    that explains them, adds it to the model, and validates that on held-out bags. The verdict may
    also be that nothing is missing, or that no cause in the library explains the gap.

    The model may be a rig's configuration, or only the known sections of a test stand's: these
    and the recorded signals determine which balances can be compared.
    """
    from pneu_rig_ros.diagnosis.result import answer
    from pneu_rig_ros.diagnosis.workflow import diagnose as run
    from pneu_rig_ros.executor import open_executor
    from pneu_rig_ros.model import effects
    from pneu_rig_ros.report.diagnosis_page import write_files

    for name in settings['without']:
        if name not in effects.names():  # empirical terms are no candidates
            effects.cause(name, '--without')
    with (
        options.directory(out, empty=True),
        open_executor(workers, scheduler) as executor,
        output.stage_bar() as progress,
    ):
        diagnosis = run(bags, executor=executor, progress=progress, **settings)
        progress('comparing before and after', COMPARING)
        data = answer(diagnosis)
        left = 1 - DRAWING
        write_files(out, diagnosis, data, lambda done: progress('drawing', DRAWING + left * done))
    if output.as_text(data):
        show(data, out)


def show(data: dict[str, Any], out: Path) -> None:
    """Print the result of a diagnosis whose files are in `out`."""
    from pneu_rig_ros.report import diagnosis_rows as rows

    terminal = output.console()
    terminal.print(data['sentence'])
    how = 'from rest to rest' if data['gap']['free_run'] else 'along the measured motion'
    bags = ', '.join(data['gap']['bags'])
    ranked = [(*one[:5], '<-' if one.chosen else '') for one in rows.ranking(data, MOST_RANKED)]
    tables: tuple[tuple[str, Sequence[str], Sequence[Sequence[str]]], ...] = (
        ('Balances', rows.BALANCES, rows.balance_rows(data, MOST_MISSING)),
        ('Significant residuals of the given model', rows.WHERE, rows.where_rows(data)),
        ('Candidate explanations', RANKING, ranked),
        ('Changed and added parameters', rows.ADDED, rows.added_rows(data)),
        (f'RMSE {how} on {bags}', rows.GAPS, rows.gap_rows(data)),
        (f'RMSE in a free run on {bags}', rows.GAPS, rows.gap_rows(data, 'free_run')),
        ('Events in the same recordings', rows.EVENTS, rows.event_rows(data)),
    )
    for title, heads, cells in tables:
        if cells:
            terminal.print()
            terminal.print(title, style='bold')
            output.print_table(heads, cells)
    terminal.print()
    alike = [' or '.join(names) for names in data['indistinguishable']]
    balances = data['gap']['of'] == 'residuals' and data['gap']['before']
    values = {
        'gap': rows.cut_text(data),
        'gap of': OF_BALANCES if balances else '',
        'remains': rows.remaining_text(data),
        'indistinguishable': '; '.join(alike),
        'notes': '\n'.join(rows.note_lines(data, MOST_NAMED)),
        'next experiment': '\n'.join(rows.next_lines(data)),
        'took': f'{data["seconds"]:.0f} s',
        'data': out / 'diagnosis.json',
        'model': out / 'improved.yaml',
        'report': out / 'report.html',
    }
    output.print_values({name: value for name, value in values.items() if value})


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
def gap(seed: int | None, out: Path | None, effect: str | None) -> None:
    """
    Hide an effect in the rig, find it, close the gap.

    Draws an effect and hides it in the plant, records experiments over ROS 2 into bags, and
    diagnoses them with a model that lacks the effect. Then records a held-out experiment again
    with this model and with the improved one. The result is a picture, the gap in numbers, and
    what was hidden.

    The effect is one of 14 of the 42 effects: those that show well above the noise in runs as
    short as these. --effect hides others too.
    """
    from pneu_rig_ros.demo import prepare_environment
    from pneu_rig_ros.scenarios.gap import DRAWN, close_gap, draw

    seed = secrets.randbelow(SEEDS) if seed is None else seed
    hidden = draw(seed, effect)
    prepare_environment()
    options.load_ros()
    path = options.bag_path(out, 'gap')
    if not (output.chosen('--json') or output.chosen('--quiet')):
        sensors = 'noise and 12 bit as on the rig, but no gain errors (accuracy class 0):\n'
        output.print_values(
            {
                'rig': f'{hidden.model.name}, with a hidden effect that its model lacks',
                'drawn from': f'{len(DRAWN)} effects, seed {seed}',
                'sensors': sensors + 'these would be fitted along with the missing effect',
            }
        )
    with _whole(path) as folder, output.stage_bar() as progress:
        outcome = close_gap(folder, hidden, seed, progress)
    if output.as_text(gap_to_dict(outcome, hidden, seed, path)):
        _reveal(outcome, hidden, path)


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


def gap_to_dict(outcome: Outcome, hidden: HiddenEffect, seed: int, path: Path) -> dict[str, Any]:
    """Return a JSON-compatible dict of the result; gaps are RMSE in the unit of their signal."""
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


def _reveal(outcome: Outcome, hidden: HiddenEffect, path: Path) -> None:
    """Print what was found, the gap, the files, and what was hidden."""
    from pneu_rig_ros.report import diagnosis_rows as rows

    terminal = output.console()
    terminal.print()
    terminal.print(outcome.answer['sentence'], style='bold')
    terminal.print('\nRMSE on a held-out run, recorded again with each model')
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
