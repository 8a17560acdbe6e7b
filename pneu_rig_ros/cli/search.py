"""`pneu-rig claims --search`: settings of what the paper does not print, ranked."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pneu_rig_ros.cli import output

if TYPE_CHECKING:
    from pneu_rig_ros.claims.experiments import Reading
    from pneu_rig_ros.claims.search import Outcome
    from pneu_rig_ros.model.quantity import Specification

SHOWN = 10
"""So many settings are printed and written."""


def run_search(
    count: int, seed: int | None, workers: int | None, scheduler: str | None, out: Path | None,
    keep: int | None = None, quiet: bool = False,
) -> None:  # fmt: skip
    """
    Search, print the best settings and write them.

    :param count: number of settings
    :param seed: None for 1
    :param workers: processes, None for one a processor
    :param scheduler: address of a Dask scheduler whose workers do it instead, if any
    :param out: JSON file to write, if any
    :param keep: number of a statement that is to hold before all others, if any
    :param quiet: print nothing
    """
    from pneu_rig_ros.claims.search import search
    from pneu_rig_ros.claims.sensitivity import sensitivity, variations
    from pneu_rig_ros.cli.claims import write_text
    from pneu_rig_ros.executor import executor

    seed = 1 if seed is None else seed
    with executor(workers, scheduler) as somewhere:
        with output.step_bar('settings', count, quiet) as progress:
            outcomes = search(count, seed, somewhere, progress, keep=keep)
        best = outcomes[0].genes
        with output.step_bar('one by one', len(list(variations(best))), quiet) as progress:
            moved = sensitivity(best, somewhere, progress)
    if out:
        data = plain(outcomes, seed, keep) | {
            'one_at_a_time': {k: _keyed(v) for k, v in moved.items()}
        }
        write_text(out, json.dumps(data, indent=1, allow_nan=False) + '\n')
    if quiet:
        return
    _print(outcomes)
    _print_sensitivity(outcomes[0], moved)
    if out:
        output.print_values({'data': str(out)})


def plain(outcomes: Sequence[Outcome], seed: int, keep: int | None = None) -> dict[str, Any]:
    """Return a search as plain data; each 'reading' is one that ``--reading`` accepts."""
    from pneu_rig_ros.claims.readings import reading_values
    from pneu_rig_ros.claims.statements import STATEMENTS

    return {
        'settings_tried': len(outcomes),
        'settings_pursued': sum(outcome.pursued for outcome in outcomes),
        'seed': seed,
        'command': f'pneu-rig claims --search {len(outcomes)} --seed {seed}'
        + (f' --keep {keep}' if keep else ''),
        'statements': {str(statement.number): statement.text for statement in STATEMENTS},
        'held_by': _keyed(held_by(outcomes)),
        'best_margin': _keyed(best_margins(outcomes)),
        'best': [
            {
                'held': sum(outcome.holds.values()),
                'holds': _keyed(outcome.holds),
                'margin': _keyed(outcome.margins),
                'reading': reading_values(outcome.reading),
            }
            for outcome in outcomes[:SHOWN]
        ],
    }


def _keyed(values: Mapping[int, float]) -> dict[str, Any]:
    """Return values by number of a statement as JSON has them, in four digits."""
    return {
        str(number): bool(value) if isinstance(value, bool) else round(float(value), 4)
        for number, value in values.items()
    }


def held_by(outcomes: Sequence[Outcome]) -> dict[int, int]:
    """Return number of a statement -> number of settings under which it holds."""
    from pneu_rig_ros.claims.statements import STATEMENTS

    return {
        statement.number: sum(outcome.holds.get(statement.number, False) for outcome in outcomes)
        for statement in STATEMENTS
    }


def best_margins(outcomes: Sequence[Outcome]) -> dict[int, float]:
    """Return number of a statement -> the largest margin under any setting [-]."""
    from pneu_rig_ros.claims.statements import STATEMENTS

    return {
        statement.number: max(outcome.margins.get(statement.number, -1.0) for outcome in outcomes)
        for statement in STATEMENTS
    }


def _print(outcomes: Sequence[Outcome]) -> None:
    from rich import box
    from rich.table import Table

    from pneu_rig_ros.claims.statements import STATEMENTS

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False, show_footer=True)
    table.add_column('rank', 'held by', justify='right', no_wrap=True)
    for number, held in held_by(outcomes).items():
        table.add_column(str(number), str(held), justify='right', no_wrap=True)
    table.add_column('held', justify='right')
    for rank, outcome in enumerate(outcomes[:SHOWN], start=1):
        fares = [_fares(outcome, statement.number) for statement in STATEMENTS]
        table.add_row(str(rank), *fares, str(sum(outcome.holds.values())))
    output.print_table(table)
    terminal = output.console()
    pursued = sum(outcome.pursued for outcome in outcomes)
    terminal.print(
        f'\nyes: the statement holds; else by which share its worst finding fails; held by: of '
        f'{len(outcomes)} settings tried, of which {pursued} stick and slip on every cylinder\n',
        style='dim',
    )
    for rank, outcome in enumerate(outcomes[:SHOWN], start=1):
        terminal.print(f'{rank:>4}  {describe(outcome.reading)}')
    terminal.print()


def _print_sensitivity(best: Outcome, moved: Mapping[str, Mapping[int, float]]) -> None:
    """Print how far each quantity alone moves the statements that do not hold."""
    from rich import box
    from rich.table import Table

    failing = [number for number, holds in sorted(best.holds.items()) if not holds]
    if not failing:
        return
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    table.add_column('rank 1 with another')
    for number in failing:
        table.add_column(str(number), justify='right', no_wrap=True)
    for name, margins in moved.items():
        table.add_row(
            name.replace('_', ' '),
            *(
                _percent(max(margins.get(number, -1.0), best.margins[number]))
                for number in failing
            ),
        )
    output.print_table(table)


def _percent(margin: float) -> str:
    return 'yes' if margin >= 0.0 else f'{margin:.0%}'


def _fares(outcome: Outcome, number: int) -> str:
    margin = outcome.margins.get(number)
    return '' if margin is None else _percent(margin)


def describe(reading: Reading) -> str:
    """Return a setting in one line."""
    from pneu_rig_ros.claims.readings import SPECIFICATIONS, short_text
    from pneu_rig_ros.rig.configuration import OVERRIDES

    specifications: dict[str, Specification] = {**SPECIFICATIONS, **OVERRIDES}
    sections = {'': {**reading.friction, **reading.operation}, **reading.single}
    parts = [
        f'{section} {key} {short_text(specifications[key], value)}'.replace('_', ' ').strip()
        for section, values in sections.items()
        for key, value in values.items()
        if value != ()
    ]
    return ', '.join(parts)
