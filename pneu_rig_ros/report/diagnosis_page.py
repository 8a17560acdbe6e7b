"""A diagnosis as one self-contained HTML page that is read from top to bottom."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
from matplotlib.figure import Figure

from pneu_rig_ros.diagnosis.alternatives import rivals
from pneu_rig_ros.diagnosis.balances import Comparison
from pneu_rig_ros.diagnosis.workflow import CONSISTENT, Diagnosis
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.records.atomic_write import atomic_write
from pneu_rig_ros.records.description import git_revision
from pneu_rig_ros.report import diagnosis_rows as rows
from pneu_rig_ros.report.claims_page import data_address
from pneu_rig_ros.report.improvement_figures import draw_improvement, draw_next, runs_of
from pneu_rig_ros.report.latent_figures import Track, draw_latent, tracks_of
from pneu_rig_ros.report.shape_figure import draw_shape
from pneu_rig_ros.rig import configuration_from_yaml

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
    draw: Callable[[], Figure | None]


class Recorded(NamedTuple):
    """A recording with its use and its conditions, as texts."""

    name: str
    used: str
    duration: str
    conditions: Sequence[str]


TITLES = {
    'gas_1': 'Gas in chamber 1',
    'gas_2': 'Gas in chamber 2',
    'force': 'Forces on the piston',
}
PLACES = ('where', 'added', 'left', 'validation', 'free', 'next')
HEADS = ('Supply, absolute', 'Load', 'Rest before')
"""Conditions of a rig's recordings."""


def write_files(
    out: Path,
    diagnosis: Diagnosis,
    answer: rows.Answer,
    progress: Callable[[float], None] = lambda share: None,
) -> None:
    """
    Write diagnosis.json, report.html and improved.yaml, each as a whole or not at all.

    :param out: directory that exists
    :param answer: of the diagnosis, as plain data
    :param progress: callback(fraction of the pictures drawn)
    :raises RigError: when a file cannot be written, or a rig does not accept a fitted value
    """
    atomic_write(out / 'diagnosis.json', json.dumps(answer, indent=2, allow_nan=False) + '\n')
    write_page(out / 'report.html', diagnosis, answer, progress)
    model = diagnosis.system.to_yaml(diagnosis.improved)
    if diagnosis.system.rig is not None:
        configuration_from_yaml(model, 'improved.yaml')
    atomic_write(out / 'improved.yaml', model)


def write_page(
    path: Path, diagnosis: Diagnosis, answer: rows.Answer,
    progress: Callable[[float], None] = lambda share: None,
) -> Path:  # fmt: skip
    """
    Write the page.

    :param answer: of the diagnosis, as plain data
    :param progress: callback(fraction of the pictures drawn)
    :raises RigError: when the file cannot be written
    """
    drawings = list(_drawings(diagnosis, answer))
    pictures: dict[str, list[Picture]] = {place: [] for place in PLACES}
    for number, one in enumerate(drawings, start=1):
        figure = one.draw()
        if figure is not None:
            pictures[one.place].append(Picture(one.title, one.caption, data_address(figure)))
        progress(number / len(drawings))
    return atomic_write(path, _template().render(**_content(diagnosis, answer), pictures=pictures))


def _content(diagnosis: Diagnosis, answer: rows.Answer) -> dict[str, Any]:
    whole = bool(answer['gap']['free_run'])
    compared = 'From rest to rest' if whole else 'Along the measured motion'
    return {
        'answer': answer,
        'balances': rows.balance_rows(answer),
        'titles': TITLES,
        'runs': list(recorded(diagnosis)),
        'heads': HEADS if diagnosis.system.rig is not None else (),
        'where': rows.where_rows(answer),
        'ranking': rows.ranking(answer, MOST_RANKED),
        'added': rows.added_rows(answer),
        'sources': {one['name']: library.load(one['name']).source for one in answer['effects']},
        'tables': {compared: rows.gap_rows(answer), 'Free run': rows.gap_rows(answer, 'free_run')},
        'events': rows.event_rows(answer),
        'gap_unit': rows.gap_unit(answer),
        'gap_before': rows.number(answer['gap']['before'], 2),
        'gap_after': rows.number(answer['gap']['after'], 2),
        'cut': rows.cut_text(answer),
        'remains': rows.remaining_text(answer),
        'next_lines': list(rows.next_lines(answer)),
        'version': version('pneu_rig_ros'),
        'revision': git_revision(),
    }  # fmt: skip


def recorded(diagnosis: Diagnosis) -> Iterator[Recorded]:
    """Yield the recordings, training data first."""
    for used, dataset in (('fit', diagnosis.training), ('held-out', diagnosis.held_out)):
        for one in dataset.comparisons:
            run, operation = one.run, one.run.operation
            conditions = (
                f'{operation.supply_pressure * 1e-5:g} bar', f'{operation.load_mass:g} kg',
                f'{operation.rest_time:g} s',
            )  # fmt: skip
            shown = conditions if diagnosis.system.rig is not None else ()
            yield Recorded(run.name, used, f'{run.size * run.interval:.1f} s', shown)


def _drawings(diagnosis: Diagnosis, answer: rows.Answer) -> Iterator[Drawing]:
    yield from _latent_drawings(diagnosis, answer)
    for one in answer['effects']:
        if one['shape'] is not None:
            yield Drawing('added', f'Form of {one["name"]}', 'Factor on the formula of the '
                          'effect, linear between the points.',
                          partial(draw_shape, one['name'], one['shape']))  # fmt: skip
    for comparison in diagnosis.held_out.comparisons:
        yield from _validation_drawings(diagnosis, comparison)
    plan = diagnosis.next_experiment
    if plan is not None:
        yield Drawing(
            'next',
            'Prediction of each explanation',
            'Simulated: u held for two thirds of the time, then the valves shut.',
            partial(
                draw_next, plan, rivals(diagnosis.search), diagnosis.training.comparisons[0].run
            ),
        )


LATENT = {
    'gas': 'Missing mass flow into the chamber for the measured pressure, or the flow of heat '
    'that raises the pressure as much.',
    'force': 'Missing force along the outstroke for the measured motion; at each breakaway, the '
    'force by which the seal held more than in the model.',
}


def _latent_drawings(diagnosis: Diagnosis, answer: rows.Answer) -> Iterator[Drawing]:
    @cache
    def tracks(given: bool) -> dict[str, list[Track]]:
        improved = _improved(diagnosis) if given else None
        return tracks_of(diagnosis.training, diagnosis.given if given else diagnosis.improved,
                         improved)  # fmt: skip

    def draw(balance: str, given: bool) -> Figure | None:
        if balance not in tracks(given):
            return None
        return draw_latent(balance, tracks(given)[balance], spans_of(answer, balance, given))

    for one in answer['balances']:
        if one['open']:
            name = one['name']
            title, caption = f'{TITLES[name]} ({name})', LATENT[name.split('_')[0]]
            yield Drawing('where', title, caption, partial(draw, name, True))
            if _improved(diagnosis) is not None:
                yield Drawing('left', title, 'The same with the improved model.',
                              partial(draw, name, False))  # fmt: skip


def spans_of(
    answer: rows.Answer, balance: str, given: bool = True
) -> dict[str, list[tuple[float, float]]]:
    """Return recording -> from, to [s] where a balance of the given model is off."""
    spans: dict[str, list[tuple[float, float]]] = {}
    for one in answer['intervals'] if given else []:
        if one['balance'] == balance:
            spans.setdefault(one['recording'], []).append((one['from'], one['to']))
    return spans


def _improved(diagnosis: Diagnosis) -> Any:
    """Return the improved hypothesis, None where it is the given one."""
    if diagnosis.verdict == CONSISTENT or diagnosis.improved == diagnosis.given:
        return None
    return diagnosis.improved


def _validation_drawings(diagnosis: Diagnosis, comparison: Comparison) -> Iterator[Drawing]:
    def draw(free: bool) -> Figure:
        known = diagnosis.held_out.aligned(diagnosis.improved, comparison)
        return draw_improvement(runs_of(known, diagnosis.given, _improved(diagnosis), free))

    name = comparison.run.name
    if not comparison.free:
        yield Drawing('validation', f'{name}, along the measured motion',
                      'The motion is the measured one; the simulation has only the first readings '
                      'of the pressures.', partial(draw, False))  # fmt: skip
        return
    yield Drawing(
        'validation',
        f'{name}, from rest to rest',
        'The simulation starts again from the readings at every rest.',
        partial(draw, False),
    )
    yield Drawing(
        'free',
        f'{name}, free run',
        'The simulation has only the first readings and the valve voltages. A slip at another '
        'time displaces it for the rest of the run.',
        partial(draw, True),
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
