"""A diagnosis as one self-contained HTML page that is read from top to bottom."""

import json
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path

from matplotlib.figure import Figure

from pneu_rig_ros.diagnosis.answer.alternatives import rivals
from pneu_rig_ros.diagnosis.answer.verdict import CONSISTENT
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.dataset import RunData
from pneu_rig_ros.diagnosis.workflow import Diagnosis
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.records.atomic_write import atomic_write
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
from pneu_rig_ros.report.page import Draw
from pneu_rig_ros.rig import configuration_from_yaml

MOST_RANKED = 12
"""Candidates on the page."""
TITLES = {
    'gas_1': 'Gas in chamber 1',
    'gas_2': 'Gas in chamber 2',
    'force': 'Forces on the piston',
}
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
    figures = _figures(diagnosis, answer)
    page.write(
        out / 'report.html',
        'diagnosis_page.html',
        figures,
        lambda number: progress(number / len(figures)),
        answer=answer,
        rows=rows,
        titles=TITLES,
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


def _figures(diagnosis: Diagnosis, answer: rows.Answer) -> dict[str, Draw]:
    """Return name of each figure -> function that draws it."""
    improved, first = improved_of(diagnosis), diagnosis.training.comparisons[0].run
    figures = _latent_figures(diagnosis, answer, improved)
    figures |= {f'form {one["name"]}': partial(draw_shape, one) for one in answer['effects']}
    for index, data in enumerate(diagnosis.held_out.runs):
        draw = partial(_draw_held_out, diagnosis, improved, data)
        figures[f'validation {index}'] = draw
        figures[f'free {index}'] = partial(draw, free=True)
    plan, explanations = diagnosis.next_experiment, rivals(diagnosis.search)
    return {**figures, 'next': partial(draw_next, plan, explanations, first)}


def _latent_figures(
    diagnosis: Diagnosis, answer: rows.Answer, improved: Hypothesis | None
) -> dict[str, Draw]:
    """Return the figures of the latent inputs under the given and the improved model."""

    @cache
    def tracks(left: bool) -> dict[str, list[Track]]:
        if not left:
            return tracks_of(diagnosis.training, diagnosis.given, improved)
        return {} if improved is None else tracks_of(diagnosis.training, improved, None)

    def draw(balance: str, left: bool) -> Figure | None:
        if (found := tracks(left).get(balance)) is None:
            return None
        if left:
            return draw_latent(balance, found, {})
        return draw_latent(balance, found, spans_of(answer, balance), diagnosis.significant)

    return {
        f'{what} {one["name"]}': partial(draw, one['name'], what == 'left')
        for one in answer['balances']
        if one['open']
        for what in ('latent', 'left')
    }


def _draw_held_out(
    diagnosis: Diagnosis, improved: Hypothesis | None, data: RunData, free: bool = False
) -> Figure | None:
    if free and not data.comparison.free:
        return None
    aligned = data.aligned(diagnosis.improved)
    return draw_improvement(runs_of(aligned, diagnosis.given, improved, free))


def spans_of(answer: rows.Answer, balance: str) -> dict[str, list[tuple[float, float]]]:
    """Return recording -> from, to [s] where a balance of the given model disagrees."""
    spans: dict[str, list[tuple[float, float]]] = {}
    for one in answer['intervals']:
        if one['balance'] == balance:
            spans.setdefault(one['recording'], []).append((one['from'], one['to']))
    return spans
