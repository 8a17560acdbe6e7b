"""
Repeat the diagnoses of docs/hardware.md, and write their outputs and figures into the page.

A command of the page is followed by a comment with the name of its bench and the balance whose
latent input is drawn, `none` without figures. `python -m benchmarks.hardware NAME...` repeats
only these benches.
"""

import argparse
import contextlib
import io
import os
import re
import shlex
import textwrap
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import click

from pneu_rig_ros.cli import command
from pneu_rig_ros.cli.diagnosis import show
from pneu_rig_ros.diagnosis.result import answer
from pneu_rig_ros.diagnosis.workflow import Diagnosis, diagnose
from pneu_rig_ros.executor import open_executor
from pneu_rig_ros.report.diagnosis_page import improved_of, spans_of
from pneu_rig_ros.report.figure import save_png
from pneu_rig_ros.report.improvement_figures import draw_improvement, runs_of
from pneu_rig_ros.report.latent_figures import draw_latent, tracks_of

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / 'docs' / 'hardware.md'
BLOCK = re.compile(
    r'```\nD=(?P<data>\S+)\n(?P<command>pneu-rig diagnose .*?)\n```\n\n'
    r'<!-- (?P<name>\w+): (?P<balance>\w+) -->\n',
    re.DOTALL,
)
CALIBRATED = {'seal_calibration': ROOT / 'config' / 'systems' / 'seal_O-ring257_calibrated.yaml'}
"""Bench -> shipped file that is its improved model."""
CALIBRATED_HEAD = (
    '# Made by `make hardware` of the first recordings of O-ring257, see docs/hardware.md.\n'
)
LEFT_OUT = ('took', 'data', 'model', 'report')
"""Lines of the output that differ between machines."""
WIDTH = 110
"""Of a line of output; longer ones are wrapped [character]."""
CAPTIONS = {
    'latent': 'Latent input with the model as given',
    'held_out': 'Held-out recording: measured and predicted',
}
"""Figure -> its caption."""


class Bench(NamedTuple):
    """
    A diagnosis of the page.

    :param name: in the page and in the names of its figures
    :param balance: whose latent input is drawn, 'none' without figures
    :param line: the command, without line breaks
    """

    name: str
    balance: str
    line: str


def main() -> None:
    """Repeat the benches that were named, all by default."""
    known = {bench.name: bench for bench in benches()}
    parser = argparse.ArgumentParser(prog='python -m benchmarks.hardware', description=__doc__)
    parser.add_argument('names', nargs='*', metavar='NAME', help=', '.join(known))
    parser.add_argument('--workers', type=int, help='processes, one per processor by default')
    arguments = parser.parse_args()
    os.chdir(ROOT)
    for name in arguments.names or known:
        update(name, repeat(known[name], arguments.workers))


def benches() -> list[Bench]:
    """Return the benches in the order of the page."""
    found = BLOCK.finditer(PAGE.read_text(encoding='utf-8'))
    return [
        Bench(
            match['name'],
            match['balance'],
            match['command'].replace('\\\n', ' ').replace('$D', match['data']),
        )
        for match in found
    ]


def repeat(bench: Bench, workers: int | None) -> str:
    """Run a diagnosis, draw its figures, and return what the command prints."""
    arguments = shlex.split(bench.line)[2:]
    options: dict[str, Any] = (
        command.commands['diagnose']
        .make_context('diagnose', arguments, parent=click.Context(command))
        .params
    )
    settings = {
        name: options[name] for name in ('bags', 'model', 'verify', 'mapping', 'seed', 'without')
    }
    with open_executor(workers) as executor:
        diagnosis = diagnose(**settings, executor=executor)
    data = answer(diagnosis)
    if bench.name in CALIBRATED:
        path = CALIBRATED[bench.name]
        improved = replace(diagnosis.improved_system, name=path.stem)
        path.write_text(CALIBRATED_HEAD + improved.to_yaml(), encoding='utf-8')
    if bench.balance != 'none':
        draw(bench, diagnosis, data)
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        show(data, Path(options['out']))
    return printed.getvalue()


def draw(bench: Bench, diagnosis: Diagnosis, data: dict[str, Any]) -> None:
    """Draw the latent input with the given model, and the last held-out recording."""
    improved = improved_of(diagnosis)
    tracks = tracks_of(diagnosis.training, diagnosis.given, improved)[bench.balance]
    latent = draw_latent(bench.balance, tracks, spans_of(data, bench.balance))
    comparison = diagnosis.held_out.runs[-1].aligned(diagnosis.improved)
    held_out = draw_improvement(runs_of(comparison, diagnosis.given, improved))
    for kind, figure in zip(CAPTIONS, (latent, held_out), strict=True):
        save_png(figure, picture(bench.name, kind))


def picture(name: str, kind: str) -> Path:
    """Return the file of a figure of a bench."""
    return PAGE.parent / 'images' / f'{name}_{kind}.png'


def update(name: str, printed: str) -> None:
    """Put the output of a bench into the page, and its figures where they are drawn."""
    lines = [line.rstrip() for line in printed.splitlines()]
    kept = [line for line in lines if not line or line.split()[0] not in LEFT_OUT]
    wrapped = [part for line in kept for part in (textwrap.wrap(line, WIDTH) or [''])]
    parts = ['```text\n' + '\n'.join(wrapped).strip() + '\n```']
    parts += [
        f'![{caption}](images/{picture(name, kind).name})'
        for kind, caption in CAPTIONS.items()
        if picture(name, kind).exists()
    ]
    put(name, '\n\n'.join(parts))


def put(name: str, text: str) -> None:
    """Put a text into the page, after the comment that begins with a name."""
    block = re.compile(rf'(<!-- {name}\b.*? -->\n).*?(<!-- end -->)', re.DOTALL)
    page = PAGE.read_text(encoding='utf-8')
    page = block.sub(lambda match: f'{match[1]}\n{text}\n\n{match[2]}', page)
    PAGE.write_text(page, encoding='utf-8')


if __name__ == '__main__':
    main()
