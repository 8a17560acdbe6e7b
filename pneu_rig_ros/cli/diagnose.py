"""`pneu-rig diagnose`: where a model and measured bags disagree, why, and a better model."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.cli import options, output
from pneu_rig_ros.cli.several import SeveralToVerify
from pneu_rig_ros.errors import RigError

if TYPE_CHECKING:
    from rich.table import Table

    from pneu_rig_ros.diagnosis.workflow import Diagnosis

MOST_RANKED = 8
"""Candidates that are printed."""
MOST_MISSING = 3
"""Missing keys and signals of a closed balance that are printed."""
COMPARING, DRAWING = 0.96, 0.97
"""Shares of the work when before and after are compared, and when the report is drawn [-]."""


@click.command(
    cls=SeveralToVerify,
    short_help='What the model lacks: the missing effect or the wrong parameter',
    epilog='\b\nExamples:\n'
    '  pneu-rig diagnose runs/a runs/b runs/c --model cylinder_1 --out answer\n'
    '  pneu-rig diagnose runs/a runs/b --verify runs/c --model rig.yaml --out answer\n'
    '  pneu-rig diagnose daq_*.csv --map map.yaml --model rig.yaml --out answer\n'
    '  pneu-rig diagnose bench_*.csv --map map.yaml --model chambers.yaml --out answer\n'
    '\b\nThen:\n'
    '  ros2 run pneu_rig_ros plant --ros-args -p cylinder:=answer/improved.yaml\n'
    '\b\nThe conditions of a bag are in its conditions.yaml, those of daq.csv beside it in\n'
    'daq.conditions.yaml:\n'
    '  supply_pressure: 4 bar gauge\n'
    '  load_mass: 0.2 kg\n',
)
@click.argument('bags', metavar='BAG...', nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option('--model', required=True, metavar='NAME|FILE', help='a cylinder, or a YAML file')
@click.option(
    '--verify',
    multiple=True,
    type=click.Path(path_type=Path),
    metavar='BAG...',
    help='held-out bags for validation  [default: every third BAG]',
)
@click.option(
    '--map',
    'mapping',
    type=click.Path(path_type=Path),
    metavar='YAML',
    help='columns, signals and units of BAGs that are text tables (see import)',
)
@click.option(
    '--out',
    type=click.Path(path_type=Path),
    required=True,
    metavar='DIRECTORY',
    help='gets diagnosis.json, improved.yaml, report.html; new or empty',
)
@click.option(
    '--seed', type=options.SEED, default=0, metavar='INTEGER', show_default=True,
    help='of the propagated sensor noise',
)  # fmt: skip
@click.option(
    '--without', multiple=True, metavar='EFFECT', help='exclude an effect from the candidates'
)
@options.workers_options()
@click.option('--json', 'as_json', is_flag=True, help='print diagnosis.json')
@click.option('--quiet', is_flag=True, help='print nothing but errors')
def diagnose(bags: Sequence[Path], out: Path, as_json: bool, quiet: bool, **settings: Any) -> None:
    """
    Find out what a model lacks, from measured bags.

    Localises the residuals that exceed the noise, selects the missing effect or wrong parameter
    that explains them, adds it to the model, and validates that on held-out bags. The verdict may
    also be that nothing is missing, or that no cause in the library explains the gap.

    The model may be a rig's configuration, or only the known sections of a test stand's: these
    and the recorded signals determine which balances can be compared.
    """
    from pneu_rig_ros.executor import open_executor
    from pneu_rig_ros.model import effects

    for name in settings['without']:
        if name not in effects.names():  # empirical terms are no candidates
            effects.cause(name, '--without')
    with (
        _directory(out),
        open_executor(settings.pop('workers'), settings.pop('scheduler')) as settings['executor'],
    ):
        data = _diagnose(bags, settings, out, quiet)
    if as_json:
        output.print_json(data)
    elif not quiet:
        show(data, out)


@contextlib.contextmanager
def _directory(out: Path) -> Iterator[None]:
    """Have the directory of the answer; remove it again if nothing came of it."""
    with options.directory(out):
        try:
            empty = not any(out.iterdir())
        except OSError as error:
            raise RigError(f'--out {out}: {error.strerror}; name a new directory') from error
        if not empty:
            raise RigError(f'--out {out} is not empty; name a new or an empty directory')
        yield


def _diagnose(
    bags: Sequence[Path], settings: dict[str, Any], out: Path, quiet: bool
) -> dict[str, Any]:
    """Diagnose behind a progress bar and write the files; return diagnosis.json."""
    from pneu_rig_ros.diagnosis.result import answer
    from pneu_rig_ros.diagnosis.workflow import diagnose as find_out

    with output.stage_bar(quiet=quiet) as progress:
        diagnosis = find_out(bags, progress=progress, **settings)
        progress('before and after', COMPARING)
        data = answer(diagnosis)
        write_files(
            out, diagnosis, data, lambda s: progress('drawing', DRAWING + (1 - DRAWING) * s)
        )
    return data


def write_files(
    out: Path, diagnosis: Diagnosis, data: dict[str, Any], progress: Callable[[float], None]
) -> None:
    """Write diagnosis.json, report.html and improved.yaml, each as a whole or not at all."""
    from pneu_rig_ros.records.atomic_write import atomic_write
    from pneu_rig_ros.report.diagnosis_page import write_page

    atomic_write(out / 'diagnosis.json', json.dumps(data, indent=2, allow_nan=False) + '\n')
    write_page(out / 'report.html', diagnosis, data, progress)
    atomic_write(out / 'improved.yaml', improved_yaml(diagnosis))


def improved_yaml(diagnosis: Diagnosis) -> str:
    """
    Return the model with the improved parameters and effects, ready for the plant if it is a rig.

    :raises RigError: when a fitted value is none that the model takes
    """
    from pneu_rig_ros.rig.configuration import configuration_from_yaml

    text = diagnosis.improved_system.to_yaml(diagnosis.improved)
    if diagnosis.system.rig is not None:
        configuration_from_yaml(text, 'improved.yaml')
    return text


def show(data: dict[str, Any], out: Path) -> None:
    """Print the answer for a person."""
    terminal = output.console()
    terminal.print(data['sentence'])
    for title, table in _tables(data):
        terminal.print()
        terminal.print(title, style='bold')
        output.print_table(table)
    terminal.print()
    output.print_values(_values(data, out))


BALANCES = ('balance', 'model and measurement', '>remaining excess')
WHERE = (
    'balance', 'regime', 'most in', '>mean', '>noise', 'unit', '>significance', 'longest'
)  # fmt: skip
RANKING = ('candidate', 'kind', 'stage', '>remaining excess', '')
ADDED = ('parameter', '>was', '>value', '>95 % interval', 'unit')
SHRUNK = ('signal', '>before', '>after', '>noise', 'unit', '>before/noise', '>after/noise')
EVENTS = ('', '>measured', '>before', '>after')
"""Heads of the tables that are printed; '>' is for numbers."""


def _tables(data: dict[str, Any]) -> Iterator[tuple[str, Table]]:
    """Yield the titles and tables that are not empty."""
    from pneu_rig_ros.report import diagnosis_rows as rows

    tables: list[tuple[str, Sequence[str], Sequence[Sequence[str]]]] = [
        ('Balances', BALANCES, rows.balance_rows(data, MOST_MISSING)),
        ('Significant residuals of the given model', WHERE, rows.where_rows(data)),
        ('Candidate explanations', RANKING, rows.ranking_texts(data, MOST_RANKED)),
        ('Changed and added parameters', ADDED, rows.added_rows(data)),
        (_compared(data), SHRUNK, rows.gap_rows(data)),
        ('Events in the same recordings', EVENTS, rows.event_rows(data)),
    ]
    yield from ((title, output.table(heads, cells)) for title, heads, cells in tables if cells)


def _compared(data: dict[str, Any]) -> str:
    """Return what the RMSE are of: a simulation, and recordings."""
    how = 'from rest to rest' if data['gap']['free_run'] else 'along the measured motion'
    return f'RMSE {how} on {", ".join(data["gap"]["bags"])}'


def _values(data: dict[str, Any], out: Path) -> dict[str, str]:
    from pneu_rig_ros.report import diagnosis_rows as rows

    values = {'gap': rows.cut_text(data)}
    if remains := rows.remaining_text(data):
        values['remains'] = remains
    if alike := data['indistinguishable']:
        values['indistinguishable'] = '; '.join(' or '.join(names) for names in alike)
    if lines := list(rows.next_lines(data)):
        values['next experiment'] = f'\n{"":<{output.NAME_WIDTH}}'.join(lines)
    values['took'] = f'{data["seconds"]:.0f} s'
    files = {'data': 'diagnosis.json', 'model': 'improved.yaml', 'report': 'report.html'}
    return values | {name: str(out / file) for name, file in files.items()}
