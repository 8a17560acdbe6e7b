"""`pneu-rig claims`: the paper's statements, measured."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.cli import options, output
from pneu_rig_ros.errors import RigError

if TYPE_CHECKING:
    from rich.text import Text

    from pneu_rig_ros.claims.experiments import Laboratory, Reading
    from pneu_rig_ros.claims.findings import Row

STDOUT = '-'


@options.command(
    'pneu-rig claims',
    'pneu-rig claims --html claims.html',
    'pneu-rig claims --reading plainest --no-neighbours',
    'pneu-rig claims --reading my_reading.yaml --json | jq .[].holds',
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
@click.option('--html', type=options.NewFile(), metavar='FILE', help='write an HTML page')
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
    reading: str,
    html: Path | None,
    as_json: str | None,
    markdown: bool,
    neighbours: bool,
    quiet: bool,
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
    from pneu_rig_ros.records.whole_files import atomic_write
    from pneu_rig_ros.report.claims_page import SHOWS, write_page

    laboratory = experiments.Laboratory(load_reading(reading))
    rows = []
    with output.progress_bar('statements', len(STATEMENTS), quiet=quiet) as progress:
        for done, statement in enumerate(STATEMENTS, start=1):
            rows.append(measure(laboratory, statement))
            progress(done)
    shares = _neighbour_shares(laboratory.reading, quiet) if neighbours else {}
    files = {}
    if html:
        with output.progress_bar('figures', len(SHOWS), quiet=quiet) as progress:
            files['page'] = write_page(html, rows, laboratory, shares, progress)
    data = [to_dict(row, shares) for row in rows]
    text = json.dumps(data, indent=2, allow_nan=False)
    if file:
        files['data'] = atomic_write(file, text + '\n')
    if as_json == STDOUT:
        click.echo(text)
    elif markdown:
        click.echo(findings.markdown(rows, shares))
    elif not quiet:
        _print(rows, laboratory, shares)
        output.print_values(files)


def _neighbour_shares(reading: Reading, quiet: bool) -> dict[int, float]:
    """Return number of a statement -> share of the neighbours under which it holds [-]."""
    from pneu_rig_ros.claims.statements import failures, neighbours
    from pneu_rig_ros.executor import open_executor

    total = len(list(neighbours(reading)))
    bar = output.progress_bar('neighbours', total, quiet=quiet)
    with open_executor(None) as executor, bar as progress:
        fails = failures(reading, executor, progress)
    return {number: 1.0 - len(names) / total for number, names in fails.items()}


def to_dict(row: Row, shares: Mapping[int, float]) -> dict[str, Any]:
    """Return a row for JSON; ``neighbours`` is a share [-], None if not measured."""
    return {
        'statement': row.statement.number,
        'expected': row.statement.text,
        'measured': [
            {'finding': finding.says, 'measured': finding.measured, 'holds': bool(finding.holds)}
            for finding in row.findings
        ],
        'holds': bool(row.holds),
        'neighbours': shares.get(row.statement.number),
    }


def _print(rows: Sequence[Row], laboratory: Laboratory, shares: Mapping[int, float]) -> None:
    from pneu_rig_ros.claims.captions import stroke_texts
    from pneu_rig_ros.claims.readings import printed_values_changed

    finding = 'expected: measured (tightest, or all that fail)'
    heads = ['>no.', 'the paper says', finding, 'verdict']
    output.print_table([*heads, '>neighbours'] if shares else heads, _cells(rows, shares), True)
    terminal = output.console()
    terminal.print()
    for text in stroke_texts(laboratory):
        terminal.print(text)
    held = sum(row.holds for row in rows)
    reading = laboratory.reading
    terminal.print(f'{held} of {len(rows)} statements hold under the reading {reading.name!r}')
    if changed := printed_values_changed(reading):
        terminal.print(f'which changes values that the paper prints: {", ".join(changed)}')


def _cells(rows: Sequence[Row], shares: Mapping[int, float]) -> Iterator[list[str | Text]]:
    """Yield the cells of each row of the table."""
    from rich.text import Text

    for row in rows:
        verdict = Text('holds', 'green') if row.holds else Text('does not', 'red')
        number = row.statement.number
        share = [f'{shares[number]:.0%}'] if shares else []
        yield [str(number), row.statement.text, measured(row), verdict, *share]


def measured(row: Row) -> str:
    """Return the finding with the least margin, or all that fail."""
    failed = [f'NOT {f.says}: {f.measured}' for f in row.findings if not f.holds]
    return '\n'.join(failed) or f'{row.tightest.says}: {row.tightest.measured}'
