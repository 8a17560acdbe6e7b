"""`pneu-rig claims`: the paper's statements, measured."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.cli import options, output
from pneu_rig_ros.errors import RigError

if TYPE_CHECKING:
    from pneu_rig_ros.claims.experiments import Laboratory, Reading
    from pneu_rig_ros.claims.findings import Row

STDOUT = '-'
SEARCH_OPTIONS = ('seed', 'workers', 'scheduler', 'out', 'keep')
OTHER_OPTIONS = ('reading', 'html', 'as_json', 'markdown')


@click.command(
    short_help="The paper's statements, each measured: holds or does not",
    epilog='\b\nExamples:\n'
    '  pneu-rig claims\n'
    '  pneu-rig claims --html claims.html\n'
    '  pneu-rig claims --reading my_reading.yaml --json | jq .[].holds\n'
    '  pneu-rig claims --search 500 --seed 1 --workers 2 --out search.json\n'
    '\b\nA reading is a YAML file with what differs from the shipped cylinders:\n'
    '  friction: {stop_velocity: 0.001 m/s, static_friction_reading: follows_clock}\n'
    '  rest_time: 900.0 s\n',
)
@click.option(
    '--reading',
    metavar='NAME|FILE',
    help='values for what the paper does not print  [default: those of the shipped cylinders]',
)
@click.option(
    '--html', type=click.Path(path_type=Path), metavar='FILE', help='write a page with all curves'
)
@click.option(
    '--json',
    'as_json',
    is_flag=False,
    flag_value=STDOUT,
    metavar='[FILE|-]',
    help='write plain data for scripts; without FILE print it in place of the table',
)
@click.option('--markdown', is_flag=True, default=None, help='print a short table in Markdown')
@click.option(
    '--search',
    type=options.Whole(1, 1_000_000),
    metavar='N',
    help='instead, try N settings of what the paper does not print and rank them',
)
@click.option('--seed', type=options.SEED, metavar='INTEGER', help='of the search  [default: 1]')
@click.option(
    '--keep',
    type=options.Whole(1, 10),
    metavar='NUMBER',
    help='of a statement that is to hold before all others, in the search',
)
@options.workers_options()
@click.option(
    '--out', type=click.Path(path_type=Path), metavar='FILE', help='write the search as JSON'
)
@options.quiet_option
def claims(search: int | None, quiet: bool, **given: Any) -> None:
    """
    Measure every statement of the paper on simulated strokes.

    Prints a row for each: what the paper says, what was measured, whether it holds. The exit code
    is 0 whatever holds.
    """
    _check_together(search is not None, given)
    for option in ('html', 'out'):
        if given[option]:
            given[option] = options.new_file(given[option], f'--{option}')
    if search is not None:
        from pneu_rig_ros.cli.search import run_search

        run_search(
            search, given['seed'], given['workers'], given['scheduler'], given['out'],
            given['keep'], quiet,
        )  # fmt: skip
    else:
        source = given['reading'] or 'default'
        _measure(source, given['html'], given['as_json'], given['markdown'], quiet)


def _check_together(searching: bool, given: dict[str, Any]) -> None:
    """Refuse options that would do nothing."""
    for name in OTHER_OPTIONS if searching else SEARCH_OPTIONS:
        if given[name] is not None:
            option = '--json' if name == 'as_json' else f'--{name}'
            verb = 'does not go with' if searching else 'needs'
            raise RigError(f'{option} {verb} --search')


def _measure(
    source: str, page: Path | None, as_json: str | None, markdown: bool | None, quiet: bool
) -> None:
    file = None if as_json in (None, STDOUT) else options.new_file(Path(str(as_json)), '--json')
    if markdown and as_json == STDOUT:
        raise RigError('--markdown does not go with --json without FILE: both print')
    if page and file and page.resolve() == file.resolve():
        raise RigError(f'--html and --json both name {page}; give each a file of its own')

    from pneu_rig_ros.claims.experiments import Laboratory
    from pneu_rig_ros.claims.readings import load_reading

    laboratory = Laboratory(load_reading(source))
    rows = _carry_out(laboratory, page, quiet)
    files = {'page': page} if page else {}
    if file:
        files['data'] = write_text(file, _text(rows))
    if as_json == STDOUT:
        click.echo(_text(rows), nl=False)
    elif markdown:
        from pneu_rig_ros.report.claims_table import markdown as table

        click.echo(table(rows))
    elif not quiet:
        _print(rows, laboratory.reading)
        output.print_values({name: str(path) for name, path in files.items()})


def _carry_out(laboratory: Laboratory, page: Path | None, quiet: bool) -> list[Row]:
    """Measure all statements and write the page, if one is asked for, behind a progress bar."""
    from pneu_rig_ros.claims.statements import STATEMENTS, measure

    rows = []
    with output.step_bar('statements', len(STATEMENTS), quiet) as progress:
        for number, statement in enumerate(STATEMENTS, start=1):
            rows.append(measure(laboratory, statement))
            progress(number)
    if page:
        from pneu_rig_ros.report.claims_figures import pictures
        from pneu_rig_ros.report.claims_page import write_page

        with output.step_bar('figures', len(list(pictures())), quiet) as progress:
            write_page(page, rows, laboratory, progress)
    return rows


def _text(rows: Sequence[Row]) -> str:
    return json.dumps([plain(row) for row in rows], indent=2, allow_nan=False) + '\n'


def plain(row: Row) -> dict[str, Any]:
    """Return a row as plain data: statement, expected, measured, holds."""
    return {
        'statement': row.statement.number,
        'expected': row.statement.text,
        'measured': [
            {'finding': finding.says, 'measured': finding.measured, 'holds': bool(finding.holds)}
            for finding in row.findings
        ],
        'holds': bool(row.holds),
    }


def write_text(path: Path, text: str) -> Path:
    """Write a file; RigError if it cannot be written."""
    try:
        path.write_text(text, encoding='utf-8')
    except OSError as error:
        raise RigError(f'cannot write {path}: {error.strerror}') from error
    return path


def _print(rows: Sequence[Row], reading: Reading) -> None:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    from pneu_rig_ros.claims.readings import printed_values_changed

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False, show_lines=True)
    table.add_column('no.', justify='right')
    table.add_column('the paper says', max_width=34)
    table.add_column('measured (in full: what does not hold)')
    table.add_column('verdict', no_wrap=True)
    for row in rows:
        statement, style = row.statement, 'green' if row.holds else 'red'
        verdict = Text('holds' if row.holds else 'does not', style)
        table.add_row(str(statement.number), statement.text, _measured(row), verdict)
    output.print_table(table)
    terminal = output.console()
    held = sum(row.holds for row in rows)
    terminal.print()
    terminal.print(f'{held} of {len(rows)} statements hold under the reading {reading.name!r}')
    if changed := printed_values_changed(reading):
        terminal.print(f'which changes values that Table 2 prints: {", ".join(changed)}')


def _measured(row: Row) -> str:
    """Return what was measured: a line a cylinder of all that holds, and what does not."""
    held: dict[str, list[str]] = {}
    for finding in row.findings:
        if finding.holds:
            cylinder = re.match(r'cylinder_\d', finding.says)
            held.setdefault(f'{cylinder[0]}: ' if cylinder else '', []).append(finding.measured)
    lines = [cylinder + '; '.join(measured) for cylinder, measured in held.items()]
    failed = [f'NOT {f.says}: {f.measured}' for f in row.findings if not f.holds]
    return '\n'.join([*lines, *failed])
