"""Commands on the model: effects and sweep."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.cli import options, output
from pneu_rig_ros.errors import RigError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.text import Text

    from pneu_rig_ros.model.effect import Effect

PRINTED = 40
"""Strokes that are printed."""


@options.command(
    'pneu-rig effects',
    'pneu-rig effects --json | jq .supply_droop.parameters',
    after='An effect is switched on in the YAML file of a rig:\n'
    '  effects: {supply_droop: {resistance: 2e9 Pa*s/kg}}\n',
)
@options.json_option
def effects(as_json: bool) -> None:
    """
    List what the model can add to the paper's equations.

    Each effect is listed with the balance it enters, the regimes of motion in which it shows, its
    source, and its parameters: unit, range, and the null value with which it vanishes. Effects
    that complete a friction law name the laws. The empirical terms at the end describe what no
    effect explains; they are not physical causes.
    """
    from pneu_rig_ros.model import effects as library

    data = {name: to_dict(library.load(name)) for name in library.names()}
    if as_json:
        output.print_json(data)
        return
    heads = ('balance', 'description')
    output.print_table(('effect', *heads), _rows(data, describes=False), lines=True)
    output.console().print()
    output.console().print('Empirical terms, not physical causes', style='bold')
    output.print_table(('term', *heads), _rows(data, describes=True), lines=True)


def to_dict(effect: Effect) -> dict[str, Any]:
    """Return the declarations of an effect as a JSON-compatible dict."""
    from pneu_rig_ros.model.quantity import Quantity, specifications

    parameters = {
        name: {**asdict(spec), 'null': getattr(effect.null, name)}
        for name, spec in specifications(effect.parameters).items()
        if isinstance(spec, Quantity)
    }
    return {
        'title': effect.title,
        'balance': effect.balance.name.lower(),
        'regimes': [regime.label for regime in effect.regimes],
        'describes': effect.describes,
        'source': effect.source,
        'states': list(effect.states),
        'laws': list(effect.laws),
        'drivers': list(effect.drivers),
        'parameters': parameters,
        'probes': [probe._asdict() for probe in effect.probes],
    }


def _rows(data: dict[str, dict[str, Any]], describes: bool) -> Iterator[tuple[str | Text, ...]]:
    """Yield name, balance and description of the effects that describe, or of the others."""
    from rich.text import Text

    for name, effect in data.items():
        if effect['describes'] is not describes:
            continue
        lines = [effect['title']]
        for key, parameter in effect['parameters'].items():
            low, high, null = (f'{parameter[bound]:g}' for bound in ('low', 'high', 'null'))
            unit = '' if parameter['unit'] == '-' else f' {parameter["unit"]}'
            text = parameter['description']
            lines.append(f'{key}: {text}; {low} to {high}{unit}, null {null}')
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
    '--longest', options.LENGTH, 100.0, 'SECOND', 'time after which a stroke is given up [s]'
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
    as_json: bool,
    quiet: bool,
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
    from pneu_rig_ros.records.whole_files import atomic_write

    # In the order of the help text, not of the command line.
    names = ('u', *(option[2:].replace('-', '_') for option, _, _ in options.CONDITIONS))
    given = [(name, text) for name in names if (text := values[name]) is not None]
    axes = [grid.axis(name, text) for name, text in (*given, *map(_varied, vary))]
    size = grid.check_size(axes)
    configuration = options.load(cylinder, {'friction': friction})
    start = time.perf_counter()
    bar = output.progress_bar('strokes', size, quiet=quiet)
    with open_executor(workers, scheduler) as executor, bar as progress:
        measures = grid.sweep(configuration, axes, longest, executor, progress)
    seconds = time.perf_counter() - start
    units, rows = grid.units(axes), grid.rows(axes, measures)
    files = {'table': atomic_write(out, grid.to_csv(units, rows))} if out else {}
    if as_json:
        strokes = [
            {name: None if value != value else value for name, value in row.items()}
            for row in rows
        ]
        output.print_json({'units': units, 'strokes': strokes, **files})
    if as_json or quiet:
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
