"""The answer of a diagnosis as rows of text, for the terminal and for the page."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

Answer = Mapping[str, Any]
"""What `pneu_rig_ros.gap.answer.answer` returns, or diagnosis.json holds."""

UNITS = {
    'm': ('mm', 1e3),
    'm/s': ('mm/s', 1e3),
    'Pa': ('kPa', 1e-3),
    'kg/s': ('mg/s', 1e6),
}
"""SI unit -> unit for people, units of it in one SI unit."""

EVENTS = {'cycles': 'stick-slip cycles', 'dwell': 'mean dwell', 'stroke_time': 'stroke time'}

NOT_KNOWN = '-'

PLAIN_BELOW = 10_000
"""Numbers below it have no exponent."""


class Where(NamedTuple):
    """Where a balance disagrees."""

    balance: str
    regime: str
    rms: str
    noise: str
    unit: str
    significance: str
    longest: str


class Ranked(NamedTuple):
    """A possible explanation; ``left`` is the share of the gap that it leaves, 0 to 1."""

    name: str
    kind: str
    stage: str
    gap_left: str
    left: float
    chosen: bool


class Added(NamedTuple):
    """A parameter that was changed or added."""

    name: str
    was: str
    value: str
    interval: str
    unit: str


class Shrunk(NamedTuple):
    """The gap of one signal, in its unit and in multiples of its noise."""

    signal: str
    before: str
    after: str
    noise: str
    unit: str
    before_multiple: str
    after_multiple: str


class Event(NamedTuple):
    """What happened in the measured runs and in both simulations."""

    what: str
    measured: str
    before: str
    after: str


def number(value: float, digits: int = 3) -> str:
    """
    Return a value with so many digits that count, zeros at the end too.

    Below 10 000 the digits before the point are all there, in the place of an exponent.
    """
    text = f'{value:#.{digits}g}'.removesuffix('.')
    return f'{value:.0f}' if 'e+' in text and round(abs(value)) < PLAIN_BELOW else text


def where_rows(answer: Answer) -> list[Where]:
    """Return where the model disagrees, the most significant first."""
    rows = []
    for one in answer['where']:
        unit, scale = UNITS.get(one['unit'], (one['unit'], 1.0))
        rms, noise = (number(scale * one[name]) for name in ('rms', 'noise'))
        times = f'{one["significance"]:.1f}'
        rows.append(Where(one['balance'], one['regime'], rms, noise, unit, times, _longest(one)))
    return rows


def _longest(one: Mapping[str, Any]) -> str:
    if not one['intervals']:
        return NOT_KNOWN
    span = one['intervals'][0]
    return f'{span["bag"]}, {span["from"]:.2f}-{span["to"]:.2f} s'


def ranking(answer: Answer, most: int) -> list[Ranked]:
    """Return the best candidates, best first."""
    added = {one['name'] for one in (*answer['parameters'], *answer['effects'])}
    rows = []
    for one in answer['candidates'][:most]:
        names, left = one['names'], one['gap_left']
        chosen = one['stage'] == 'fitted' and set(names) <= added
        text = f'{left:.0%}' if left < 9.995 else 'over 999%'
        rows.append(Ranked(' + '.join(names), _kind(names), one['stage'], text, left, chosen))
    return rows


def _kind(names: Sequence[str]) -> str:
    kinds = {'parameter' if '.' in name else 'effect' for name in names}
    if len(kinds) == 2:
        return 'both'
    return next(iter(kinds)) + ('s' if len(names) > 1 else '')


def ranking_texts(answer: Answer, most: int) -> list[tuple[str, ...]]:
    """Return the best candidates as texts, an arrow beside the one that was chosen."""
    return [
        (one.name, one.kind, one.stage, one.gap_left, '<-' if one.chosen else '')
        for one in ranking(answer, most)
    ]


def added_rows(answer: Answer) -> list[Added]:
    """Return the parameters that were changed, and those of the effects that were added."""
    rows = [_added(one['name'], number(one['was'], 4), one) for one in answer['parameters']]
    for effect in answer['effects']:
        for name, value in effect['parameters'].items():
            rows.append(_added(f'{effect["name"]}.{name}', NOT_KNOWN, value))
    return rows


def _added(name: str, was: str, one: Mapping[str, Any]) -> Added:
    low, high = (number(value, 4) for value in one['interval'])
    texts = number(one['value'], 4), f'{low} to {high}'
    return Added(name, was, *texts, one['unit'])


def gap_rows(answer: Answer, which: str = 'signals') -> list[Shrunk]:
    """
    Return the gap of each signal before and after.

    :param which: 'signals' for predictions from rest to rest, 'free_run' for whole runs
    """
    return [_shrunk(name, one) for name, one in answer['gap'].get(which, {}).items()]


def _shrunk(name: str, one: Mapping[str, Any]) -> Shrunk:
    unit, scale = UNITS.get(one['unit'], (one['unit'], 1.0))
    before, after, noise = (number(scale * one[key]) for key in ('before', 'after', 'noise'))
    multiples = (f'{one[key] / one["noise"]:.1f}' for key in ('before', 'after'))
    return Shrunk(name.replace('_', ' '), before, after, noise, unit, *multiples)


def event_rows(answer: Answer) -> list[Event]:
    """Return what happened in the runs left out of the fit, and in both simulations."""
    rows = []
    for name, what in EVENTS.items():
        if (one := answer['gap'].get(name)) is not None:
            texts = (_event(one[key], one['unit']) for key in ('measured', 'before', 'after'))
            rows.append(Event(what, *texts))
    return rows


def _event(value: float | None, unit: str) -> str:
    if value is None or math.isnan(value):
        return NOT_KNOWN
    return f'{value:g}' if unit == '-' else f'{value:.3g} {unit}'


def cut_text(answer: Answer) -> str:
    """Return in a sentence how far the gap shrank on the runs left out of the fit."""
    gap = answer['gap']
    if gap['before'] <= 0.0:
        return 'there is no gap above the noise'
    before, after = (number(gap[key], 2) for key in ('before', 'after'))
    calibrated = answer['verdict'] == 'consistent' and answer.get('calibration')
    means = ' by the slopes of the sensors' if calibrated else ''
    return (f'{before} noise floors above the noise before, {after} after: '
            f'{gap["cut"]:.0%} of the gap is closed{means}')  # fmt: skip


def next_lines(answer: Answer) -> Iterator[str]:
    """Yield what to measure next, nothing if nothing is left to be told apart."""
    plan = answer['next_experiment']
    if plan is None:
        return
    start = 1e3 * plan['initial_position']
    yield (f'u = {plan["u"]:g} V, supply {plan["supply_pressure"] * 1e-5:g} bar absolute, '
           f'load {plan["load_mass"]:g} kg, from {start:.0f} mm')  # fmt: skip
    yield f'which sets these at least {plan["by"]:.1f} times the noise apart:'
    yield ', '.join(plan['separates'])
