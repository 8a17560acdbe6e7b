"""`pneu-rig sweep`: strokes over a grid of conditions and parameters."""

from __future__ import annotations

import csv
import io
import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.cli import options, output
from pneu_rig_ros.errors import RigError

if TYPE_CHECKING:
    from pneu_rig_ros.sweep.axes import Axis
    from pneu_rig_ros.sweep.run import Measures

SHOWN = 40
"""So many strokes are printed."""
CONDITIONS = ('supply_pressure', 'load_mass', 'initial_position', 'rest_time')


@click.command(
    short_help='Strokes over a grid of commands, conditions and parameters',
    epilog='\b\nExamples:\n'
    '  pneu-rig sweep --u 0.3:0.6:31 --out table.csv\n'
    '  pneu-rig sweep --cylinder cylinder_1 --u 0.29,0.32 --supply-pressure 4e5:8e5:5\n'
    '  pneu-rig sweep --vary friction.stribeck_velocity=0.005:0.05:10 --json\n'
    '  pneu-rig sweep --vary chamber_leak.area_1=0:4e-9:9 --u 0.34\n'
    '  pneu-rig sweep --u 0.2:1:999 --load-mass 0:5:999 --scheduler tcp://host:8786 --json\n'
    '\b\nVALUES are a number, A,B,... or LOW:HIGH:COUNT, in SI units.\n',
)
@click.option('--cylinder', default='cylinder_2', show_default=True, metavar='NAME|FILE',
              help='cylinder_1, cylinder_2, cylinder_3, or a YAML file of your own')  # fmt: skip
@click.option('--friction', metavar='MODEL', help='name of the friction law')
@click.option('--u', default='0.34', show_default=True, metavar='VALUES', help='command [V]')
@click.option('--supply-pressure', metavar='VALUES', help='absolute [Pa]')
@click.option('--load-mass', metavar='VALUES', help='external load [kg]')
@click.option('--initial-position', metavar='VALUES', help='from the cap end [m]')
@click.option('--rest-time', metavar='VALUES', help='rest before the start [s]')
@click.option('--vary', multiple=True, metavar='KEY=VALUES',
              help='section.key of the model, or effect.parameter; may be repeated')  # fmt: skip
@click.option('--longest', type=float, default=100.0, show_default=True, metavar='SECOND',
              help='a stroke is given up after this time [s]')  # fmt: skip
@options.workers_options(default=1, help='processes; 1 is this one, with a thread per processor')
@click.option('--out', type=click.Path(path_type=Path), metavar='FILE', help='write a CSV table')
@click.option('--json', 'as_json', is_flag=True, help='print plain data for scripts')
@options.quiet_option
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
    Simulate an outstroke, or an instroke, at every point of a grid.

    Each begins at rest and is simulated as far as the end of the stroke, without noise. Prints
    its time, stick-slip cycles, dwells, slips and friction. The numbers do not depend on the
    number of workers.
    """
    if not 0.0 < longest <= 86_400.0:
        raise RigError(f'--longest {longest:g}: must be above 0 and at most 86400 s')
    file = options.new_file(out, '--out') if out else None

    from pneu_rig_ros.executor import open_executor
    from pneu_rig_ros.sweep import axes as grid
    from pneu_rig_ros.sweep.run import sweep as run

    axes = [grid.axis(name, text) for name, text in (*_given(values), *_varied(vary))]
    size = grid.check_size(axes)
    configuration = options.load(cylinder, {'friction': friction})
    start = time.perf_counter()
    bar = output.step_bar('strokes', size, quiet)
    with open_executor(workers, scheduler) as executor, bar as progress:
        rows = run(configuration, axes, longest, executor, progress)
    _tell(axes, rows, file, time.perf_counter() - start, as_json, quiet)


def _given(values: dict[str, str | None]) -> list[tuple[str, str]]:
    return [(name, values[name] or '') for name in ('u', *CONDITIONS) if values[name] is not None]


def _varied(vary: Sequence[str]) -> list[tuple[str, str]]:
    pairs = []
    for text in vary:
        key, equals, values = text.partition('=')
        if not (equals and '.' in key):
            raise RigError(f'--vary {text}: expected KEY=VALUES, KEY as friction.coulomb_force')
        pairs.append((key, values))
    return pairs


def _tell(
    axes: Sequence[Axis], rows: Sequence[Measures], out: Path | None, seconds: float,
    as_json: bool, quiet: bool,
) -> None:  # fmt: skip
    """Write the table, and print it or plain data."""
    from pneu_rig_ros.cli.claims import write_text

    if out:
        write_text(out, _csv(axes, rows))
    if as_json:
        output.print_json(_plain(axes, rows) | ({'table': str(out)} if out else {}))
    elif not quiet:
        _print(axes, rows)
        files = {'table': str(out)} if out else {}
        output.print_values({'strokes': f'{len(rows)} in {seconds:.1f} s'} | files)


def _records(axes: Sequence[Axis], rows: Sequence[Measures]) -> list[dict[str, Any]]:
    """Return a mapping for each stroke: what is varied, and what was measured."""
    from pneu_rig_ros.sweep.run import grid

    return [
        {one.name: one.shown(value) for one, value in zip(axes, point, strict=True)}
        | row._asdict()
        for point, row in zip(grid(axes), rows, strict=True)
    ]


def _units(axes: Sequence[Axis]) -> dict[str, str]:
    """Return the unit of each column."""
    from pneu_rig_ros.sweep.run import UNITS

    return {one.name: one.unit for one in axes} | UNITS


def _csv(axes: Sequence[Axis], rows: Sequence[Measures]) -> str:
    """Return a table with names as 'stroke_time_s'; a cell is empty where nothing is measured."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator='\n')
    writer.writerow(name if unit == '-' else f'{name}_{unit.replace("/", "_per_")}'
                    for name, unit in _units(axes).items())  # fmt: skip
    for record in _records(axes, rows):
        writer.writerow('' if value != value else value for value in record.values())
    return text.getvalue()


def _plain(axes: Sequence[Axis], rows: Sequence[Measures]) -> dict[str, Any]:
    return {
        'units': _units(axes),
        'strokes': [
            {name: None if value != value else value for name, value in record.items()}
            for record in _records(axes, rows)
        ],
    }


def _print(axes: Sequence[Axis], rows: Sequence[Measures]) -> None:
    """Print the first strokes."""
    heads = [f'>{name.replace("_", " ")}' + ('' if unit == '-' else f' [{unit}]')
             for name, unit in _units(axes).items()]  # fmt: skip
    cells = [[_cell(value) for value in record.values()]
             for record in _records(axes, rows)[:SHOWN]]  # fmt: skip
    output.print_table(output.table(heads, cells))
    if len(rows) > SHOWN:
        output.console().print(f'... {len(rows) - SHOWN} more: --out FILE writes all')


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return output.NOT_KNOWN if math.isnan(value) else f'{value:.4g}'
    return str(value)
