"""`pneu-rig diagnose`: where a model and measured bags disagree, why, and a better model."""

import contextlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import click

from pneu_rig_ros.cli import options, output
from pneu_rig_ros.errors import RigError

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
    help='held-out bags for validation  [default: every third BAG, of one its last third]',
)
@options.map_option(help='columns, signals and units of BAGs that are text tables (see import)')
@options.out_directory(
    required=True, help='for diagnosis.json, improved.yaml, report.html; new or empty'
)
@options.seed_option(default=0, show_default=True, help='seed of the propagated sensor noise')
@click.option(
    '--without', multiple=True, metavar='EFFECT', help='exclude an effect from the candidates'
)
@options.workers_options()
@options.output_options
def diagnose(
    bags: Sequence[Path],
    out: Path,
    workers: int | None,
    scheduler: str | None,
    as_json: bool,
    quiet: bool,
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
        _directory(out),
        open_executor(workers, scheduler) as executor,
        output.stage_bar(quiet) as progress,
    ):
        diagnosis = run(bags, executor=executor, progress=progress, **settings)
        progress('comparing before and after', COMPARING)
        data = answer(diagnosis)
        left = 1 - DRAWING
        write_files(out, diagnosis, data, lambda done: progress('drawing', DRAWING + left * done))
    if as_json:
        output.print_json(data)
    elif not quiet:
        show(data, out)


@contextlib.contextmanager
def _directory(out: Path) -> Iterator[None]:
    """Create the directory for the results, or use an empty one; remove it on failure."""
    with options.directory(out):
        try:
            empty = not any(out.iterdir())
        except OSError as error:
            raise RigError(f'--out {out}: {error.strerror}; name a new directory') from error
        if not empty:
            raise RigError(f'--out {out} is not empty; name a new or an empty directory')
        yield


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
    values = {
        'gap': rows.cut_text(data),
        'gap of': OF_BALANCES
        if data['gap']['of'] == 'residuals' and data['gap']['before']
        else '',
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
