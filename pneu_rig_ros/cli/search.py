"""`pneu-rig claims --search`: settings of what the paper does not print, ranked."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pneu_rig_ros.cli import output

if TYPE_CHECKING:
    from pneu_rig_ros.claims.experiments import Reading
    from pneu_rig_ros.claims.search import Outcome

SHOWN = 10
"""So many settings are printed and written."""


def run_search(count: int, seed: int | None, workers: int | None, out: Path | None) -> None:
    """
    Search, print the best settings and write them.

    :param count: number of settings
    :param seed: None for 1
    :param workers: processes, None for one a processor
    :param out: JSON file to write, if any
    """
    from pneu_rig_ros.claims.search import search
    from pneu_rig_ros.cli.claims import write_text

    seed = 1 if seed is None else seed
    with output.step_bar('settings', count) as progress:
        outcomes = search(count, seed, workers or os.cpu_count() or 1, progress)
    if out:
        write_text(out, json.dumps(plain(outcomes, seed), indent=1, allow_nan=False) + '\n')
    _print(outcomes)
    if out:
        output.print_values({'data': str(out)})


def plain(outcomes: Sequence[Outcome], seed: int) -> dict[str, Any]:
    """Return a search as plain data; each 'reading' is one that ``--reading`` accepts."""
    from pneu_rig_ros.claims.readings import reading_values
    from pneu_rig_ros.claims.search import WANTED
    from pneu_rig_ros.claims.statements import STATEMENTS

    return {
        'settings_tried': len(outcomes),
        'seed': seed,
        'statements': {str(statement.number): statement.text for statement in STATEMENTS},
        'ranked_first_by': list(WANTED),
        'held_by': {str(number): held for number, held in held_by(outcomes).items()},
        'best': [
            {
                'held': sum(outcome.holds.values()),
                'holds': {str(number): bool(held) for number, held in outcome.holds.items()},
                'share': {str(number): round(s, 4) for number, s in outcome.share.items()},
                'reading': reading_values(outcome.reading),
            }
            for outcome in outcomes[:SHOWN]
        ],
    }


def held_by(outcomes: Sequence[Outcome]) -> dict[int, int]:
    """Return number of a statement -> number of settings under which it holds."""
    numbers = outcomes[0].holds
    return {number: sum(outcome.holds[number] for outcome in outcomes) for number in numbers}


def _print(outcomes: Sequence[Outcome]) -> None:
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False, show_footer=True)
    table.add_column('rank', 'held by', justify='right', no_wrap=True)
    for number, held in held_by(outcomes).items():
        table.add_column(str(number), str(held), justify='right', no_wrap=True)
    table.add_column('held', justify='right')
    for rank, outcome in enumerate(outcomes[:SHOWN], start=1):
        fares = [_fares(outcome, number) for number in outcome.holds]
        table.add_row(str(rank), *fares, str(sum(outcome.holds.values())))
    output.print_table(table)
    terminal = output.console()
    terminal.print(
        f'\nyes: the statement holds; else the share of its findings that hold; '
        f'held by: of {len(outcomes)} settings tried\n',
        style='dim',
    )
    for rank, outcome in enumerate(outcomes[:SHOWN], start=1):
        terminal.print(f'{rank:>4}  {describe(outcome.reading)}')
    terminal.print()


def _fares(outcome: Outcome, number: int) -> str:
    return 'yes' if outcome.holds[number] else f'{outcome.share[number]:.0%}'


def describe(reading: Reading) -> str:
    """Return a setting in one line."""
    from pneu_rig_ros.claims.readings import SPECIFICATIONS, short_text

    parts = [
        f'{key.replace("_", " ")} {short_text(SPECIFICATIONS[key], value)}'
        for key, value in reading.friction.items()
        if value != ()
    ]
    rest = reading.rest_time
    return ', '.join(parts if rest is None else [*parts, f'rest time {rest:.6g} s'])
