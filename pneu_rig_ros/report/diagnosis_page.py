"""A diagnosis as one self-contained HTML page that is read from top to bottom."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache, partial
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
from matplotlib.figure import Figure

from pneu_rig_ros.gap.diagnosis import Diagnosis
from pneu_rig_ros.gap.experiment import Experiment
from pneu_rig_ros.gap.prediction import Mode
from pneu_rig_ros.gap.where import SIGNIFICANT
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.records.description import git_revision
from pneu_rig_ros.report import diagnosis_rows as rows
from pneu_rig_ros.report.claims_page import data_address
from pneu_rig_ros.report.residual_figures import (
    Blocks,
    blocks_of,
    draw_dependence,
    draw_over_time,
    half_heights,
)
from pneu_rig_ros.report.shrink_figures import draw_next, draw_shrink, runs_of
from pneu_rig_ros.report.writing import write_whole

MOST_RANKED = 12
"""Candidates on the page."""


class Picture(NamedTuple):
    """A drawn figure and what it shows."""

    title: str
    caption: str
    address: str


class Drawing(NamedTuple):
    """A figure to be drawn: its part of the page, title, caption."""

    place: str
    title: str
    caption: str
    draw: Callable[[], Figure]


class Conditions(NamedTuple):
    """A run for people: its conditions, and what it was used for."""

    name: str
    used: str
    duration: str
    supply: str
    load: str
    rest: str


def write_page(
    path: Path, diagnosis: Diagnosis, answer: rows.Answer,
    progress: Callable[[float], None] = lambda share: None,
) -> Path:  # fmt: skip
    """
    Write the page.

    :param answer: of the diagnosis, as plain data
    :param progress: told the share of the pictures drawn [-]
    :raises RigError: when the file cannot be written
    """
    drawings = list(_drawings(diagnosis))
    pictures: dict[str, list[Picture]] = {'where': [], 'left': [], 'shrink': [], 'free': [],
                                         'next': []}  # fmt: skip
    for number, one in enumerate(drawings, start=1):
        pictures[one.place].append(Picture(one.title, one.caption, data_address(one.draw())))
        progress(number / len(drawings))
    return write_whole(path, _template().render(**_content(diagnosis, answer), pictures=pictures))


def _content(diagnosis: Diagnosis, answer: rows.Answer) -> dict[str, Any]:
    return {
        'answer': answer,
        'significant': f'{SIGNIFICANT:g}',
        'runs': list(conditions(diagnosis)),
        'where': rows.where_rows(answer),
        'ranking': rows.ranking(answer, MOST_RANKED),
        'added': rows.added_rows(answer),
        'sources': {name: library.load(name).source for name in diagnosis.best.effects},
        'tables': {'From rest to rest': rows.gap_rows(answer),
                   'Free run': rows.gap_rows(answer, 'free_run')},
        'events': rows.event_rows(answer),
        'gap_before': rows.number(answer['gap']['before'], 2),
        'gap_after': rows.number(answer['gap']['after'], 2),
        'cut': rows.cut_text(answer),
        'next_lines': list(rows.next_lines(answer)),
        'version': version('pneu_rig_ros'),
        'revision': git_revision(),
    }  # fmt: skip


def conditions(diagnosis: Diagnosis) -> Iterator[Conditions]:
    """Yield the runs, those of the fits first."""
    for used, evidence in (('fit', diagnosis.fitted), ('left out', diagnosis.held)):
        for one in evidence.experiments:
            operation = one.operation
            supply = f'{operation.supply_pressure * 1e-5:g} bar'
            yield Conditions(
                one.name, used, f'{one.record.duration:.1f} s', supply,
                f'{operation.load_mass:g} kg', f'{operation.rest_time:g} s',
            )  # fmt: skip


BEYOND = 'Each point is a mean over 29 ms; those beyond the scale are drawn at its edge.'


def _drawings(diagnosis: Diagnosis) -> Iterator[Drawing]:
    yield from _residual_drawings(diagnosis)
    for experiment in diagnosis.held.experiments:
        yield from _shrink_drawings(diagnosis, experiment)
    plan = diagnosis.next_experiment
    if plan is not None:
        yield Drawing(
            'next',
            'What each would show',
            'Simulated: u held for two thirds of the time, then the valves shut.',
            partial(draw_next, plan, diagnosis.rivals, diagnosis.fitted.experiments[0]),
        )


def _residual_drawings(diagnosis: Diagnosis) -> Iterator[Drawing]:
    @cache
    def blocks(of: str) -> list[Blocks]:
        hypothesis = {'given': diagnosis.given, 'best': diagnosis.best}[of]
        return blocks_of(hypothesis, diagnosis.fitted, diagnosis.seed)

    yield Drawing(
        'where',
        'Over time',
        f'The residual of each balance with the model as given. {BEYOND}',
        lambda: draw_over_time(blocks('given')),
    )
    yield Drawing(
        'where',
        'Against what it may depend on',
        'The same residuals. Dwell is the time that the piston has rested, or had rested before '
        'it slid.',
        lambda: draw_dependence(blocks('given')),
    )
    if diagnosis.verdict != 'consistent':
        yield Drawing(
            'left',
            'What is left',
            'The residuals with the improved model, on the scale of those above.',
            lambda: draw_over_time(blocks('best'), half_heights(blocks('given'))),
        )


def _shrink_drawings(diagnosis: Diagnosis, experiment: Experiment) -> Iterator[Drawing]:
    def draw(mode: Mode) -> Figure:
        return draw_shrink(runs_of(diagnosis, experiment, mode))

    yield Drawing(
        'shrink',
        f'{experiment.name}, from rest to rest',
        'The simulation starts again from the readings at every rest.',
        partial(draw, Mode.CYCLES),
    )
    yield Drawing(
        'free',
        f'{experiment.name}, free run',
        'The simulation has the first readings and the valve voltages, nothing else. A slip that '
        'comes at another time sets it off for the rest of the run.',
        partial(draw, Mode.FREE),
    )


def _template() -> jinja2.Template:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader('pneu_rig_ros', 'report'),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template('diagnosis_page.html')
