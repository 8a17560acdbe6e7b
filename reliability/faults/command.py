"""``python -m reliability faults``: does all of it, prints and keeps the table."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from benchmarks.__main__ import machine
from pneu_rig_ros.cli import output
from reliability import figures
from reliability.faults import clocks, commands, disks, graph, kills, starts
from reliability.faults.finding import Fault, Finding, NotPossible, Scene, Stage
from reliability.live_rig import own_domain

TOGETHER: tuple[Fault, ...] = (
    graph.standing_still,
    graph.wrong_quality,
    graph.two_rigs,
    commands.two_publishers,
    commands.flood,
    kills.kill_nodes,
    kills.kill_recorder,
    graph.late_joiners,
    disks.removed_bag,
)
"""Faults of one rig, one after the other."""

ALONE: tuple[Fault, ...] = (
    starts.killed_demo,
    starts.killed_in_live,
    disks.full_disk,
    disks.unwritable_folder,
    clocks.clock_jump,
    starts.wrong_middleware,
)
"""Faults that need a rig of their own."""

FAULTS: dict[str, Fault] = {fault.__name__: fault for fault in (*TOGETHER, *ALONE)}
"""By name, in the order of the table."""

KILLED = 4
"""Nodes that are killed `times` times."""


@click.command()
@click.option('--times', default=20, show_default=True, help='how often each node is killed')
@click.option('--only', type=click.Choice(list(FAULTS)), multiple=True, help='these faults')
def faults(times: int, only: tuple[str, ...]) -> None:
    """Let the rig meet its faults; prove what it does then."""
    own_domain()
    chosen = only or tuple(FAULTS)
    found: dict[str, Finding | str] = {}
    with output.step_bar('faults', KILLED * times + len(chosen)) as progress, Stage() as stage:
        done = 0

        def step() -> None:
            nonlocal done
            done += 1
            progress(done)

        for name in chosen:
            found[name] = meet(name, stage, times, step)
            step()
    tell(found)
    if not only:
        figures.keep('faults', plain(found), text(found))
    if not all(isinstance(finding, str) or finding.held for finding in found.values()):
        raise SystemExit(1)


def meet(
    name: str, stage: Stage, times: int = 1, step: Callable[[], None] = lambda: None
) -> Finding | str:
    """Return what came of a fault, or in a line why it could not be tried."""
    if FAULTS[name] in ALONE:
        stage.clear()
    with tempfile.TemporaryDirectory(prefix='pneu_rig_fault_') as folder:
        try:
            return FAULTS[name](Scene(Path(folder), stage, times, step))
        except NotPossible as why:
            return str(why)


def tell(found: dict[str, Finding | str]) -> None:
    """Print what was measured."""
    rows = [
        (name, finding, '') if isinstance(finding, str)
        else (finding.fault, finding.measured, 'yes' if finding.held else 'NO')
        for name, finding in found.items()
    ]  # fmt: skip
    output.print_table(output.table(('fault', 'measured', 'held'), rows))


def plain(found: dict[str, Finding | str]) -> dict[str, Any]:
    """Return what was found as plain data."""
    return {
        name: finding if isinstance(finding, str) else finding._asdict()
        for name, finding in found.items()
    }


def text(found: dict[str, Finding | str]) -> str:
    """Return what the page says."""
    heads = 'fault', 'what happens', 'how it is told', 'measured'
    rows = [
        finding[:4] if isinstance(finding, Finding) else (name, '', '', f'not tried: {finding}')
        for name, finding in found.items()
    ]
    lines = ['| ' + ' | '.join(cell.replace('|', '/') for cell in row) + ' |' for row in rows]
    ruler = '|' + ' --- |' * len(heads)
    table = '\n'.join(['| ' + ' | '.join(heads) + ' |', ruler, *lines])
    return (
        '`make faults`: live rigs of four processes each, and a witness beside them that keeps '
        f'every message it receives and compares it with the bag.\n\n{table}\n\n{machine()}.'
    )
