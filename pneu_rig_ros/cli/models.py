"""Commands on the model: effects, sweep and claims."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.cli import options, output
from pneu_rig_ros.errors import RigError

if TYPE_CHECKING:
    from rich.text import Text

    from pneu_rig_ros.claims.experiments import Laboratory, Reading
    from pneu_rig_ros.claims.findings import Row
    from pneu_rig_ros.model.effect import Effect

PRINTED = 40
"""Strokes that are printed."""
STDOUT = '-'


@options.command(
    'pneu-rig effects',
    'pneu-rig effects --json | jq .supply_droop.parameters',
    after='An effect is switched on in the YAML file of a rig:\n'
    '  effects: {supply_droop: {resistance: 2e9 Pa*s/kg}}\n',
)
@options.json_option
def effects() -> None:
    """
    List what the model can add to the paper's equations.

    Each effect is listed with the balance it enters, the regimes of motion in which it shows, its
    source, and its parameters: unit, range, and the null value with which it vanishes. Effects
    that complete a friction law name the laws. The empirical terms at the end describe what no
    effect explains; they are not physical causes.
    """
    from pneu_rig_ros.model import effects as library

    data = {name: _effect(library.load(name)) for name in library.names()}
    if not output.as_text(data):
        return
    heads = ('balance', 'description')
    output.print_table(('effect', *heads), _effect_rows(data, describes=False), lines=True)
    output.console().print()
    output.console().print('Empirical terms, not physical causes', style='bold')
    output.print_table(('term', *heads), _effect_rows(data, describes=True), lines=True)


def _effect(effect: Effect) -> dict[str, Any]:
    """Return the declarations of an effect as a JSON-compatible dict."""
    from pneu_rig_ros.model.quantity import specifications

    return {
        'title': effect.title,
        'balance': effect.balance.name.lower(),
        'regimes': [regime.label for regime in effect.regimes],
        'describes': effect.describes,
        'source': effect.source,
        'states': list(effect.states),
        'laws': list(effect.laws),
        'drivers': list(effect.drivers),
        'parameters': {
            name: {**asdict(quantity), 'null': getattr(effect.null, name)}
            for name, quantity in specifications(effect.parameters).items()
        },
        'probes': [probe._asdict() for probe in effect.probes],
    }


def _effect_rows(data: Mapping[str, Any], describes: bool) -> Iterator[tuple[str | Text, ...]]:
    """Yield name, balance and description of the effects that describe, or of the others."""
    from rich.text import Text

    for name, effect in data.items():
        if effect['describes'] is not describes:
            continue
        lines = [effect['title']]
        for key, parameter in effect['parameters'].items():
            text = '{description}; {low:g} to {high:g} {unit}'.format(**parameter)
            lines.append(f'{key}: {text.removesuffix(" -")}, null {parameter["null"]:g}')
        lines.append(f'shows in: {", ".join(effect["regimes"])}')
        if effect['laws']:
            lines.append(f'for the laws: {", ".join(effect["laws"])}')
        description = Text('\n'.join(lines)).append(f'\n{effect["source"]}', 'dim')
        yield name, effect['balance'].replace('_', ' '), description


@options.command(
    'pneu-rig sweep --u 0.3:0.6:31 --out table.csv',
    'pneu-rig sweep --cylinder cylinder_1 --u 0.29,0.32 --supply-pressure 4e5:8e5:5',
    'pneu-rig sweep --vary friction.stribeck_velocity=0.005:0.05:10 --json',
    'pneu-rig sweep --vary chamber_leak.area_1=0:4e-9:9 --u 0.34',
    'pneu-rig sweep --u 0.2:1:999 --load-mass 0:5:999 --scheduler tcp://host:8786 --json',
    after='VALUES are a number, A,B,... or LOW:HIGH:COUNT, in SI units.\n',
)
@options.cylinder_option
@options.friction_option
@click.option('--u', default='0.34', show_default=True, metavar='VALUES', help='command [V]')
@options.together(
    *(click.option(name, metavar='VALUES', help=text) for name, _, text in options.CONDITIONS)
)
@click.option(
    '--vary',
    multiple=True,
    metavar='KEY=VALUES',
    help='section.key of the model, or effect.parameter; repeatable',
)
@options.number_option(
    '--longest', options.LENGTH, 100.0, 'time after which a stroke is given up [s]', 'SECOND'
)
@options.workers_options(default=1, help='processes; 1: this one, with a thread per processor')
@options.out_file(help='write a CSV table')
@options.output_options
def sweep(
    cylinder: str,
    friction: str | None,
    vary: Sequence[str],
    longest: float,
    workers: int,
    scheduler: str | None,
    out: Path | None,
    **values: str | None,
) -> None:
    """
    Simulate strokes over a grid of conditions and parameters.

    Each outstroke or instroke begins at rest and ends at the end of the cylinder, without sensor
    noise. Prints its time, stick-slip cycles, dwells, slips and friction. The numbers do not
    depend on the number of workers.
    """
    from pneu_rig_ros import sweep as grid
    from pneu_rig_ros.executor import open_executor
    from pneu_rig_ros.records.atomic_write import atomic_write

    # In the order of the help text, not of the command line.
    names = ('u', *(option[2:].replace('-', '_') for option, _, _ in options.CONDITIONS))
    given = [(name, text) for name in names if (text := values[name]) is not None]
    axes = [grid.axis(name, text) for name, text in (*given, *map(_varied, vary))]
    size = grid.check_size(axes)
    configuration = options.load(cylinder, {'friction': friction})
    start = time.perf_counter()
    with (
        open_executor(workers, scheduler) as executor,
        output.progress_bar('strokes', size) as progress,
    ):
        measures = grid.sweep(configuration, axes, longest, executor, progress)
    seconds = time.perf_counter() - start
    units, rows = grid.units(axes), grid.rows(axes, measures)
    files = {'table': atomic_write(out, grid.to_csv(units, rows))} if out else {}
    strokes = [
        {name: None if value != value else value for name, value in row.items()} for row in rows
    ]
    if not output.as_text({'units': units, 'strokes': strokes, **files}):
        return
    heads = [
        f'>{name.replace("_", " ")}' + ('' if unit == '-' else f' [{unit}]')
        for name, unit in units.items()
    ]
    output.print_table(heads, ([_cell(value) for value in row.values()] for row in rows[:PRINTED]))
    if len(rows) > PRINTED:
        output.console().print(f'... {len(rows) - PRINTED} more: --out FILE writes all')
    output.print_values({'strokes': f'{len(rows)} in {seconds:.1f} s', **files})


def _varied(text: str) -> tuple[str, str]:
    """Return key and values of an option --vary."""
    key, equals, values = text.partition('=')
    if not (equals and '.' in key):
        raise RigError(f'--vary {text}: expected KEY=VALUES, KEY as friction.coulomb_force')
    return key, values


def _cell(value: float | str) -> str:
    if isinstance(value, float):
        return output.UNKNOWN if math.isnan(value) else f'{value:.4g}'
    return str(value)


@options.command(
    'pneu-rig claims',
    'pneu-rig claims --html claims.html',
    'pneu-rig claims --reading plainest --no-neighbours',
    'pneu-rig claims --reading my_reading.yaml --json | jq ".[].holds"',
    after='A reading is a YAML file with the values that differ from the shipped cylinders:\n'
    '  friction: {stop_velocity: 0.001 m/s, static_friction_reading: follows_clock}\n'
    '  operation: {rest_time: 900.0 s}\n',
)
@click.option(
    '--reading',
    default='default',
    metavar='NAME|FILE',
    help='values that the paper does not print  [default: those of the shipped cylinders]',
)
@click.option('--html', type=options.NewFile(), help='write an HTML page')
@click.option(
    '--json',
    'as_json',
    is_flag=False,
    flag_value=STDOUT,
    metavar='[FILE|-]',
    help='write the result as JSON; without FILE print it instead of the table',
)
@click.option('--markdown', is_flag=True, help='print a short table in Markdown')
@click.option(
    '--neighbours/--no-neighbours',
    default=True,
    help='repeat the measurement under neighbouring settings  [default: yes, about a minute]',
)
@options.quiet_option
def claims(
    reading: str, html: Path | None, as_json: str | None, markdown: bool, neighbours: bool
) -> None:
    """
    Measure each statement of the paper on simulated strokes.

    Prints a row for each statement: what the paper says, what was measured, whether it holds, and
    the share of neighbouring settings under which it holds: u, supply pressure and each unprinted
    quantity changed by 5 %, other starts along the stroke. The exit code does not depend on it.
    """
    file = None if as_json in (None, STDOUT) else options.new_file(Path(str(as_json)), '--json')
    if markdown and as_json == STDOUT:
        raise RigError('--markdown and --json without FILE both print; choose one')
    if html and file and html.resolve() == file.resolve():
        raise RigError(f'--html and --json both name {html}; name two files')

    from pneu_rig_ros.claims import experiments, findings
    from pneu_rig_ros.claims.readings import load_reading
    from pneu_rig_ros.claims.statements import STATEMENTS, measure
    from pneu_rig_ros.records.atomic_write import atomic_write
    from pneu_rig_ros.report.claims_page import SHOWS, write_page

    laboratory = experiments.Laboratory(load_reading(reading))
    rows = []
    with output.progress_bar('statements', len(STATEMENTS)) as progress:
        for done, statement in enumerate(STATEMENTS, start=1):
            rows.append(measure(laboratory, statement))
            progress(done)
    shares = _neighbour_shares(laboratory.reading) if neighbours else {}
    files = {}
    if html:
        with output.progress_bar('figures', len(SHOWS)) as progress:
            files['page'] = write_page(html, rows, laboratory, shares, progress)
    data = [row.to_dict(shares) for row in rows]
    if file:
        files['data'] = atomic_write(file, output.json_text(data) + '\n')
    if as_json == STDOUT:
        click.echo(output.json_text(data))
    elif markdown:
        click.echo(findings.markdown(rows, shares))
    elif not output.chosen('--quiet'):
        _print(rows, laboratory, shares)
        output.print_values(files)


def _neighbour_shares(reading: Reading) -> dict[int, float]:
    """Return number of a statement -> share of the neighbours under which it holds [-]."""
    from pneu_rig_ros.claims.statements import failures, neighbours
    from pneu_rig_ros.executor import open_executor

    total = len(list(neighbours(reading)))
    with open_executor(None) as executor, output.progress_bar('neighbours', total) as progress:
        fails = failures(reading, executor, progress)
    return {number: 1.0 - len(names) / total for number, names in fails.items()}


def _print(rows: Sequence[Row], laboratory: Laboratory, shares: Mapping[int, float]) -> None:
    from pneu_rig_ros.claims.captions import stroke_texts
    from pneu_rig_ros.claims.readings import printed_values_changed

    finding = 'expected: measured (tightest, or all that fail)'
    heads = ['>no.', 'the paper says', finding, 'verdict', *(['>neighbours'] if shares else [])]
    output.print_table(heads, _claim_rows(rows, shares), lines=True)
    terminal = output.console()
    terminal.print('', *stroke_texts(laboratory), sep='\n')
    reading, held = laboratory.reading, sum(row.holds for row in rows)
    terminal.print(f'{held} of {len(rows)} statements hold under the reading {reading.name!r}')
    if changed := printed_values_changed(reading):
        terminal.print(f'which changes values that the paper prints: {", ".join(changed)}')


def _claim_rows(rows: Sequence[Row], shares: Mapping[int, float]) -> Iterator[list[str | Text]]:
    """Yield the cells of each row of the table."""
    from rich.text import Text

    for row in rows:
        verdict = Text('holds', 'green') if row.holds else Text('does not', 'red')
        number = row.statement.number
        share = [f'{shares[number]:.0%}'] if shares else []
        yield [str(number), row.statement.text, row.measured, verdict, *share]
