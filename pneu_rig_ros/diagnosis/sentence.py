"""The answer of a diagnosis in one sentence."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pneu_rig_ros.diagnosis.answer.intervals import HALF_WIDTH
from pneu_rig_ros.diagnosis.answer.run_differences import RunDifference
from pneu_rig_ros.diagnosis.answer.verdict import CONDITIONS, CONSISTENT, UNCALIBRATED, UNKNOWN
from pneu_rig_ros.diagnosis.causes.candidates import CONDITIONS as CONDITIONS_PREFIX
from pneu_rig_ros.diagnosis.inputs.prepare_runs import TEMPERATURE_DRIFT
from pneu_rig_ros.diagnosis.residuals.balances import UNITS
from pneu_rig_ros.diagnosis.search.state import FREE_RUN
from pneu_rig_ros.diagnosis.workflow import Diagnosis
from pneu_rig_ros.rig.configuration import REPEATABILITY

Rows = Sequence[Mapping[str, Any]]

ENDS = 20
"""Parts of a recording of which the first and the last show by how much a pressure changed."""


def sentence(diagnosis: Diagnosis, parameters: Rows, effects: Rows, conditions: Rows) -> str:
    """Return the verdict in one sentence, from rows of the answer; what else there is to say."""
    verdict = _verdict(diagnosis, parameters, effects, conditions)
    judged = ' There is one recording: its last part was held out.' if diagnosis.single else ''
    return verdict + judged + ''.join(f' {_differs(each)}.' for each in diagnosis.differing)


def _differs(difference: RunDifference) -> str:
    """Return by how much a recording differs from the others, with half its interval."""
    factor, unit = 1.0, difference.unit
    if unit == '-':
        factor, unit = 100.0, '% of the stated value'
    low, high = difference.interval
    size, half = factor * abs(difference.difference), 0.5 * factor * (high - low)
    name = difference.quantity.name.removeprefix(CONDITIONS_PREFIX)
    place = 'above' if difference.difference > 0.0 else 'below'
    by = f'{size:.3g} +- {half:.2g} {unit} {place} theirs'
    return f'{difference.recording} differs from the others: its {name} is {by}'


def _allowance(name: str, value: float) -> str:
    """Return by how much recordings may differ in the force, a gas source or a quantity."""
    if name in UNITS:
        return f'{value:.2g} {UNITS[name]}'
    unit = REPEATABILITY[name].unit
    amount = f'{100.0 * value:.2g} %' if unit == '-' else f'{1e3 * value:.2g} m{unit}'
    return f'{name} {amount}'


def _verdict(diagnosis: Diagnosis, parameters: Rows, effects: Rows, conditions: Rows) -> str:
    """Return the verdict in one sentence, from rows of the answer."""
    verdict = diagnosis.verdict
    if verdict == CONSISTENT and (tight := _tight(diagnosis)):
        return tight
    if verdict == CONSISTENT:
        allowed = ', '.join(
            _allowance(name, value) for name, value in diagnosis.system.repeatability.items()
        )
        limits = f'repeatability ({allowed})' if allowed else 'noise'
        agree = f'odel and measurement agree within the {limits}: nothing is missing.'
        names = ' and '.join(each.recording for each in diagnosis.differing)
        return f'Except in {names}, m{agree}' if names else f'M{agree}'
    if verdict == UNCALIBRATED:
        within = 'Errors of sensors and supply within their class'
        return f'{within} explain the residuals: nothing is missing.'
    if verdict == UNKNOWN:
        where = _places(diagnosis)
        return f'Model and measurement disagree in {where}; no cause in the library explains it.'
    texts = _causes(parameters, effects)
    if conditions:
        rows = [f'{row["name"]} {row["true"]}, stated {row["stated"]}' for row in conditions]
        place = 0 if verdict == CONDITIONS else len(texts)
        texts.insert(place, 'Not as stated: ' + ' and '.join(rows))
    if diagnosis.unknown is not None:
        texts.append(f'no cause in the library explains what is left in {_places(diagnosis)}')
    if not diagnosis.significant:
        texts.append('no residual alone is significant, all of them together are')
    remaining = diagnosis.search.remaining_beyond_noise()
    if remaining >= 0.01:
        texts.append(f'{remaining:.0%} of the excess over the noise remains')
    return '; '.join(texts) + '.'


def _causes(parameters: Rows, effects: Rows) -> list[str]:
    """Return which effects and which values of parameters the model lacks."""
    texts = []
    if effects:
        names = [f'{row["name"]} ({row["title"]}){_form_text(row["shape"])}' for row in effects]
        texts.append('The model lacks ' + ' and '.join(names))
    if parameters:
        names = [str(row['name']) for row in parameters]
        texts.append(f'{" and ".join(names)} {"have" if len(names) > 1 else "has"} another value')
    return texts


def _places(diagnosis: Diagnosis) -> str:
    """Return the balances with significant residuals, or that free runs alone are off."""
    if any(residual.regime == FREE_RUN for residual in diagnosis.significant):
        return 'free runs'
    return ' and '.join(dict.fromkeys(residual.balance for residual in diagnosis.significant))


def _tight(diagnosis: Diagnosis) -> str:
    """Return the sentence on vessels whose pressure changes as with temperature, '' of others."""
    if not diagnosis.system.constant_volume or diagnosis.given.effects:
        return ''
    datasets = (diagnosis.training, diagnosis.held_out)
    runs = [each.run for data in datasets for each in data.comparisons]
    gas, changes, limits = diagnosis.given.model.gas, [], []
    for run in runs:
        chamber = 1 if 'gas_1' in run.balances else 2
        ends = [part.mean() for part in np.array_split(run.smooth[:, chamber], ENDS)[:: ENDS - 1]]
        changes.append(abs(ends[1] / ends[0] - 1.0))
        # gas that leaks this slowly stays at the temperature of the walls
        adiabatic = HALF_WIDTH * run.repeatability[f'gas_{chamber}']
        limits.append(gas.heat_capacity_ratio * adiabatic)
    if max(changes) > HALF_WIDTH * TEMPERATURE_DRIFT / gas.supply_temperature:
        return ''
    return (
        f'Too tight to tell: no pressure changes by more than {max(changes):.2%}, which a drift '
        f'of the temperature may do too; a leak below {1e6 * max(limits):.2g} mg/s cannot be seen.'
    )


def _form_text(shape: Mapping[str, Any] | None) -> str:
    """Return how an effect differs from its formula, '' where it does not."""
    if shape is None:
        return ''
    variable = shape['variable'].replace('_', ' ')
    if shape['y_unit'] != '-':
        span = f'{min(shape["y"]):.2g} to {max(shape["y"]):.2g} {shape["y_unit"]}'
        return f' in another form than the library has it: {span} over {variable}'
    trend = 'grows' if shape['y'][-1] > shape['y'][0] else 'falls'
    return f', which {trend} with {variable}'
