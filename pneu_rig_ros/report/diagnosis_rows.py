"""The answer of a diagnosis as rows of text, for the terminal and the page."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from pneu_rig_ros.diagnosis.causes.candidates import CONDITIONS
from pneu_rig_ros.records.recording import SIGNALS
from pneu_rig_ros.report.figure import display, plain_name

Answer = Mapping[str, Any]
"""What `pneu_rig_ros.diagnosis.result.answer` returns, or diagnosis.json holds."""

Row = tuple[str, ...]
"""Texts of a row of a table."""

VARIABLE_UNITS = {**SIGNALS, 'dwell': 's', 'time': 's'}
"""Variable that bounds a significant residual -> SI unit."""
SHORT = {'position': 'x', 'velocity': 'v', 'pressure_1': 'p1', 'pressure_2': 'p2', 'time': 't'}

COUNTED = {'cycles': 'stick-slip cycles', 'dwell': 'mean dwell', 'stroke_time': 'stroke time'}

NOT_KNOWN = '-'

BALANCES = ('balance', 'model and measurement', '>remaining excess')
WHERE = ('balance', 'regime', 'most in', '>mean', '>noise', 'unit', '>significance', 'longest')
ADDED = ('parameter', '>was', '>value', '>95 % interval', 'unit')
GAPS = ('signal', '>before', '>after', '>noise', 'unit', '>before/noise', '>after/noise')
EVENTS = ('', '>measured', '>before', '>after')
EACH = ('recording', 'quantity', '>value', '>95 % interval', 'unit', '>p-value')
"""Heads of the columns; one that begins with '>' is for numbers."""

LEAST_P = 1e-3
"""Smallest p-value that is given as a number [-]."""
PLAIN_BELOW = 10_000
"""Numbers below it have no exponent."""
UNDETERMINED = 100.0
"""Ratio of the ends of an interval in which not even the order of magnitude is known [-]."""


class Ranked(NamedTuple):
    """A possible explanation; ``left`` is the remaining share of the excess, None of none."""

    name: str
    kind: str
    stage: str
    gap_left: str
    probability: str
    left: float | None
    chosen: bool


def number(value: float, digits: int = 3) -> str:
    """
    Return a value with so many digits that count, zeros at the end too.

    Below 10 000 the digits before the point are all there, in the place of an exponent.
    """
    text = f'{value:#.{digits}g}'.removesuffix('.')
    return f'{value:.0f}' if 'e+' in text and round(abs(value)) < PLAIN_BELOW else text


def balance_rows(answer: Answer, most: int = 100) -> list[Row]:
    """
    Return of each balance its agreement, or what is missing to compare it.

    :param most: of the missing keys and signals that are listed
    """
    rows: list[Row] = []
    for one in answer['balances']:
        if one['open']:
            state = 'agrees' if one['verdict'] == 'consistent' else 'disagrees'
            if one['verdict'] not in ('consistent', answer['verdict']):
                state = f'disagrees: {one["verdict"]}'
        else:
            missing = one['why'].split(', ')
            more = f' and {len(missing) - most} more' if len(missing) > most else ''
            state = f'closed: no {", ".join(missing[:most])}{more}'
        rows.append((one['name'], state, _share(one['left'])))
    return rows


def _share(value: float | None, absent: str = NOT_KNOWN) -> str:
    return absent if value is None else f'{value:.0%}'


def where_rows(answer: Answer) -> list[Row]:
    """Return the significant residuals, the most significant first."""
    rows: list[Row] = []
    for one in answer['where']:
        unit, scale = display(one['unit'])
        longest = NOT_KNOWN
        if one['intervals']:
            span = one['intervals'][0]
            longest = f'{span["recording"]}, {span["from"]:.2f}-{span["to"]:.2f} s'
        regime = f'{one["regime"]} {one["direction"]}'.strip()
        mean, noise = number(scale * one['mean']), number(scale * one['noise'])
        significance = f'{one["significance"]:.1f}'
        rows.append(
            (one['balance'], regime, _range(one), mean, noise, unit, significance, longest)
        )
    return rows


def _range(one: Mapping[str, Any]) -> str:
    """Return the range of the variable in which a residual is most significant."""
    name, ends = one['variable'], (one['from'], one['to'])
    if not name or None in ends:
        return 'all'
    unit, scale = display(VARIABLE_UNITS[name])
    low, high = (number(scale * end) for end in ends)
    return f'{SHORT.get(name, name)} {low} to {high} {unit}'


def ranking(answer: Answer, most: int) -> list[Ranked]:
    """Return the best candidates, the answer first."""
    rows = []
    for one in answer['candidates'][:most]:
        left, likely = one['gap_left'], _share(one['probability'], '')
        stage = 'screened' if one['stage'] == 'screened' else 'fitted'
        what = ' + '.join(one['names']), _kind(one['names']), stage
        rows.append(Ranked(*what, _share(left), likely, left, one['chosen']))
    return rows


def _kind(names: Sequence[str]) -> str:
    kinds = {
        'condition' if name.startswith(CONDITIONS) else 'parameter' if '.' in name else 'effect'
        for name in names
    }
    return 'mixed' if len(kinds) > 1 else kinds.pop() + ('s' if len(names) > 1 else '')


def added_rows(answer: Answer) -> list[Row]:
    """Return the parameters that were changed, and those of the effects that were added."""
    entries = [(one['name'], number(one['was'], 4), one) for one in answer['parameters']]
    entries += [
        (f'{one["name"]}, ratio to the stated value', '1', one)
        if one['unit'] == '-'
        else (one['name'], '0', one)
        for one in answer['conditions']
        if one['value'] is not None
    ]
    for effect in answer['effects']:
        for name, value in effect['parameters'].items():
            entries.append((f'{effect["name"]}.{name}', NOT_KNOWN, value))
    rows: list[Row] = [
        (name, was, number(one['value'], 4), _interval(*one['interval']), one['unit'])
        for name, was, one in entries
    ]
    for effect in answer['effects']:
        for name, value in effect['readings'].items():
            rows.append((f'friction.{name}', NOT_KNOWN, value, '', ''))
    return rows


def _interval(low: float, high: float) -> str:
    """Return the text of an interval, and whether not even the order of magnitude is known."""
    text = f'{number(low, 4)} to {number(high, 4)}'
    return f'not determined: {text}' if 0.0 < UNDETERMINED * low < high else text


def gap_rows(answer: Answer, which: str = 'signals') -> list[Row]:
    """
    Return the RMSE of each signal before and after, in its unit and in multiples of its noise.

    :param which: 'signals' or 'free_run'
    """
    rows: list[Row] = []
    for name, one in answer['gap'][which].items():
        unit, scale = display(one['unit'])
        noise = one['noise']
        values = [one['before'], one['after'], noise]
        before, after, spread = (NOT_KNOWN if v is None else number(scale * v) for v in values)
        multiples = (
            f'{value / noise:.1f}' if noise and value is not None else NOT_KNOWN
            for value in values[:2]
        )
        rows.append((plain_name(name), before, after, spread, unit, *multiples))
    return rows


def event_rows(answer: Answer) -> list[Row]:
    """Return the events in the held-out recordings, and in both simulations."""
    keys = ('measured', 'before', 'after')
    rows: list[Row] = []
    for name, what in COUNTED.items():
        one = answer['gap'][name]
        if any(one[key] is not None for key in keys):
            rows.append((what, *(_event(one[key], one['unit']) for key in keys)))
    return rows


def _event(value: float | None, unit: str) -> str:
    if value is None:
        return NOT_KNOWN
    return f'{value:g}' if unit == '-' else f'{value:.3g} {unit}'


def each_rows(answer: Answer) -> list[Row]:
    """Return what is particular to each recording, with intervals and p-values."""
    rows: list[Row] = []
    for one in answer['each_recording']:
        low, high = one['interval']
        digits = _decimals(0.5 * (high - low))
        value, *ends = (f'{each:.{digits}f}' for each in (one['value'], low, high))
        p = one['p_value']
        likely = f'{p:.3f}' if p >= LEAST_P else f'< {LEAST_P:g}'
        texts = plain_name(one['name']), value, ' to '.join(ends), one['unit'], likely
        rows.append((one['recording'], *texts))
    return rows


def _decimals(error: float) -> int:
    """Return with how many decimals an error has two digits that count, at least none."""
    return max(1 - math.floor(math.log10(error)), 0)


def note_lines(answer: Answer, most: int = 100) -> Iterator[str]:
    """
    Yield each note with the recordings that it is of.

    :param most: recordings that are named in a line
    """
    recordings: dict[str, list[str]] = {}
    for one in answer['notes']:
        recordings.setdefault(one['note'], []).append(one['recording'])
    for note, names in recordings.items():
        more = f' and {len(names) - most} more' if len(names) > most else ''
        yield f'{", ".join(names[:most])}{more}: {note}'


def cut_text(answer: Answer) -> str:
    """Return in a sentence how far the gap on held-out data is closed."""
    gap = answer['gap']
    if gap['before'] <= 0.0:
        return 'no residual exceeds the noise'
    before, after = (number(gap[key], 2) for key in ('before', 'after'))
    means = ' by the gains of the sensors' if answer['verdict'] == 'uncalibrated' else ''
    return (
        f'excess over the noise {before} before, {after} after: '
        f'{gap["cut"]:.0%} of the gap is closed{means}'
    )


def remaining_text(answer: Answer) -> str:
    """Return in a sentence what no cause in the library explains, '' without such a rest."""
    unknown = answer['unknown']
    if unknown is None:
        return ''
    place = f'{unknown["balance"]}, {unknown["regime"]}'
    if not unknown['term']:
        return f'{place}; no empirical term describes it'
    return (
        f'{place}; empirical term, not a physical cause: {unknown["term"]}; '
        f'{unknown["gap_left"]:.0%} of the gap remains'
    )


SEPARABLE = 1.0
"""RMS difference from which on an experiment separates explanations [standard deviations]."""


def next_lines(answer: Answer) -> Iterator[str]:
    """Yield the next experiment, no line if no explanations compete."""
    plan = answer['next_experiment']
    if plan is None:
        return
    if plan['like']:
        yield f'a longer recording like {plan["like"]}'
    else:
        start = 1e3 * plan['initial_position']
        yield (
            f'u = {plan["u"]:g} V, supply {plan["supply_pressure"] * 1e-5:g} bar absolute, '
            f'load {plan["load_mass"]:g} kg, from {start:.0f} mm'
        )
    if plan['by'] < SEPARABLE:
        yield 'the largest difference, but within the noise; not separable:'
    else:
        yield f'separates these by at least {plan["by"]:.1f} standard deviations:'
    yield ', '.join(plan['separates'])
