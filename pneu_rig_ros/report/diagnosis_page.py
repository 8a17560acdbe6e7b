"""A diagnosis as one self-contained HTML page that is read from top to bottom."""

import json
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path

from matplotlib.figure import Figure

from pneu_rig_ros.diagnosis.answer.alternatives import rivals
from pneu_rig_ros.diagnosis.answer.verdict import CONSISTENT
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.balances import STOP_UNIT
from pneu_rig_ros.diagnosis.residuals.dataset import RunData
from pneu_rig_ros.diagnosis.workflow import Diagnosis
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.records.whole_files import atomic_write
from pneu_rig_ros.report import diagnosis_rows as rows
from pneu_rig_ros.report import page
from pneu_rig_ros.report.dependence import Track
from pneu_rig_ros.report.improvement_figures import (
    draw_improvement,
    draw_next,
    draw_shape,
    runs_of,
)
from pneu_rig_ros.report.latent_figures import draw_latent, tracks_of
from pneu_rig_ros.report.page import Drawing
from pneu_rig_ros.rig import configuration_from_yaml

MOST_RANKED = 12
"""Candidates on the page."""
TITLES = {
    'gas_1': 'Gas in chamber 1',
    'gas_2': 'Gas in chamber 2',
    'force': 'Forces on the piston',
}
LATENT = {
    'gas': 'Missing mass flow into the chamber for the measured pressure, or the flow of heat '
    'that raises the pressure as much.',
    'force': 'Missing force along the outstroke for the measured motion; at each breakaway, the '
    'force by which the seal held more than in the model. Readings at an end stop that are not at '
    'its place are listed above, not drawn.',
}
"""Captions of the latent inputs."""
HEADS = ('>supply, absolute', '>load', '>rest before')
"""Conditions of a rig's recordings."""


def write_files(
    out: Path,
    diagnosis: Diagnosis,
    answer: rows.Answer,
    progress: Callable[[float], None],
) -> None:
    """
    Write diagnosis.json, report.html and improved.yaml, atomically.

    :param out: directory that exists
    :param answer: of the diagnosis, as a JSON-compatible dict
    :param progress: callback(fraction of the pictures drawn)
    :raises RigError: when a file cannot be written, or a rig does not accept a fitted value
    """
    atomic_write(out / 'diagnosis.json', json.dumps(answer, indent=2, allow_nan=False) + '\n')
    drawings = list(_drawings(diagnosis, answer))
    page.write(
        out / 'report.html',
        'diagnosis_page.html',
        drawings,
        lambda number: progress(number / len(drawings)),
        answer=answer,
        rows=rows,
        balances=[(name, TITLES[name], *rest) for name, *rest in rows.balance_rows(answer)],
        runs=list(recorded(diagnosis)),
        heads=HEADS if diagnosis.system.rig is not None else (),
        most_ranked=MOST_RANKED,
        sources={one['name']: library.load(one['name']).source for one in answer['effects']},
    )
    model = diagnosis.improved_system.to_yaml()
    if diagnosis.system.rig is not None:
        configuration_from_yaml(model, 'improved.yaml')
    atomic_write(out / 'improved.yaml', model)


def recorded(diagnosis: Diagnosis) -> Iterator[rows.Row]:
    """Yield name, use, length and, of a rig, conditions of the recordings, training data first."""
    for used, dataset in (('fit', diagnosis.training), ('held-out', diagnosis.held_out)):
        for comparison in dataset.comparisons:
            run, operation = comparison.run, comparison.run.operation
            conditions: tuple[str, ...] = ()
            if diagnosis.system.rig is not None:
                supply = f'{operation.supply_pressure * 1e-5:g} bar'
                load, rest = f'{operation.load_mass:g} kg', f'{operation.rest_time:g} s'
                conditions = supply, load, rest
            yield run.name, used, f'{run.size * run.interval:.1f} s', *conditions


def improved_of(diagnosis: Diagnosis) -> Hypothesis | None:
    """Return the improved hypothesis, None where it is that of the system as given."""
    unchanged = diagnosis.verdict == CONSISTENT or diagnosis.improved == diagnosis.given
    return None if unchanged else diagnosis.improved


def _drawings(diagnosis: Diagnosis, answer: rows.Answer) -> Iterator[Drawing]:
    """Yield the figures in the order of the page."""
    improved = improved_of(diagnosis)
    yield from _latent_drawings(diagnosis, answer, improved)
    for effect in answer['effects']:
        if effect['shape'] is not None:
            yield Drawing(
                f'Form of {effect["name"]}',
                'Factor on the formula of the effect, linear between the points.'
                if effect['shape']['y_unit'] == '-'
                else 'What the effect adds, linear between the points.',
                partial(draw_shape, effect['name'], effect['shape']),
                'added',
            )
    for data in diagnosis.held_out.runs:
        yield from _validation_drawings(diagnosis, data, improved)
    if (plan := diagnosis.next_experiment) is not None:
        run = diagnosis.training.comparisons[0].run
        yield Drawing(
            'Prediction of each explanation',
            'Simulated: u constant for two thirds of the time, then the valves shut.',
            partial(draw_next, plan, rivals(diagnosis.search), run),
            'next',
        )


def _latent_drawings(
    diagnosis: Diagnosis, answer: rows.Answer, improved: Hypothesis | None
) -> Iterator[Drawing]:
    hypotheses = {'where': (diagnosis.given, improved), 'left': (diagnosis.improved, None)}

    @cache
    def tracks(place: str) -> dict[str, list[Track]]:
        return tracks_of(diagnosis.training, *hypotheses[place])

    def draw(balance: str, place: str) -> Figure | None:
        found = tracks(place).get(balance)
        if found is None:
            return None
        if place == 'left':
            return draw_latent(balance, found, {})
        drawn = [one for one in diagnosis.significant if one.unit != STOP_UNIT]
        marked = [one for one in drawn if one.balance == balance]
        return draw_latent(balance, found, spans_of(answer, balance), marked)

    for one in answer['balances']:
        if one['open']:
            name = one['name']
            title, caption = f'{TITLES[name]} ({name})', LATENT[name.split('_')[0]]
            yield Drawing(title, caption, partial(draw, name, 'where'), 'where')
            if improved is not None:
                caption = 'The same with the improved model.'
                yield Drawing(title, caption, partial(draw, name, 'left'), 'left')


def spans_of(answer: rows.Answer, balance: str) -> dict[str, list[tuple[float, float]]]:
    """Return recording -> from, to [s] where a balance of the given model disagrees."""
    spans: dict[str, list[tuple[float, float]]] = {}
    for one in answer['intervals']:
        if one['balance'] == balance:
            spans.setdefault(one['recording'], []).append((one['from'], one['to']))
    return spans


def _validation_drawings(
    diagnosis: Diagnosis, data: RunData, improved: Hypothesis | None
) -> Iterator[Drawing]:
    def draw(free: bool = False) -> Figure:
        aligned = data.aligned(diagnosis.improved)
        return draw_improvement(runs_of(aligned, diagnosis.given, improved, free))

    name = data.comparison.run.name
    if not data.comparison.free:
        yield Drawing(
            f'{name}, along the measured motion',
            'The motion is the measured one; the simulation has only the first readings of the '
            'pressures.',
            draw,
            'validation',
        )
        return
    yield Drawing(
        f'{name}, from rest to rest',
        'The simulation starts again from the readings at every rest.',
        draw,
        'validation',
    )
    yield Drawing(
        f'{name}, free run',
        'The simulation has only the first readings and the valve voltages. A slip at another '
        'time displaces it for the rest of the run.',
        partial(draw, True),
        'free',
    )
