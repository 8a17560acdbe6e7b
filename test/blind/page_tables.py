"""The tables of ``docs/blind.md``."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from statistics import median
from typing import Any

from pneu_rig_ros.scenarios.hidden import EFFECTS

from . import places, scores
from .answers import Answer
from .confusion import said
from .figures import Figure, Wanted, middle, pooled, share
from .fresh import FRESH_PARTS, SYSTEM_PARTS
from .trials import Trial

REACHED = {True: 'yes', False: 'no'}


def table(head: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """Return a Markdown table."""
    lines = [list(head)]
    lines.append(['---'] * len(lines[0]))
    lines += [[str(cell) for cell in row] for row in rows]
    return '\n'.join(f'| {" | ".join(line)} |' for line in lines) + '\n'


def percent(value: float | None, digits: int = 0) -> str:
    """Return a share as text."""
    return '-' if value is None else f'{100.0 * value:.{digits}f} %'


def text_of(name: str, value: float | None, digits: int = 0) -> str:
    """Return the value of a figure as text."""
    if value is None:
        return '-'
    return f'{value:.1f}' if name.startswith('seconds') else percent(value, digits)


def interval(name: str, figure: Figure) -> str:
    """Return the 95 % interval of a figure as text."""
    if figure['low'] is None or figure['high'] is None:
        return '-'
    return f'{text_of(name, figure["low"])} to {text_of(name, figure["high"])}'


def measured(name: str, figure: Figure) -> str:
    """Return a figure with its interval and number of trials as text."""
    if not figure['trials']:
        return '-'
    return f'{text_of(name, figure["value"], 1)} ({interval(name, figure)}; {figure["trials"]})'


def figure_row(name: str, figure: Figure, wanted: Wanted) -> tuple[str, ...]:
    """Return name, meaning, value, interval and goal of a figure as text."""
    value, goal = (
        text_of(name, figure['value'], 1),
        f'{wanted.sense} {text_of(name, wanted.bound)}',
    )
    return f'`{name}`', wanted.meaning, value, interval(name, figure), goal


def headline(answers: list[Answer]) -> str:
    """Return the table of the wanted figures."""
    rows = []
    for name, figure in scores.figures(answers).items():
        mark = REACHED[scores.reached(name, figure['value'])] if figure['trials'] else '-'
        row = figure_row(name, figure, scores.WANTED[name])
        rows.append((*row, mark, figure['trials']))
    head = 'figure', 'what', 'measured', '95 % interval', 'wanted', 'reached', 'trials'
    return table(head, rows)


def comparison(by_revision: dict[str, list[Answer]]) -> str:
    """Return the figures of all revisions on the trials that each of them has answered."""
    common = set.intersection(*({a['key'] for a in rows} for rows in by_revision.values()))
    both = {
        revision: scores.figures([a for a in rows if a['key'] in common])
        for revision, rows in by_revision.items()
    }
    figures = next(iter(both.values()))
    names = [
        name
        for name, figure in figures.items()
        if figure['trials'] and not name.startswith('seconds')
    ]
    rows = [(f'`{name}`', *(measured(name, own[name]) for own in both.values())) for name in names]
    head = 'figure', *by_revision
    return f'{len(common)} trials, answered by all.\n\n{table(head, rows)}'


def coverage(answers: list[Answer], whole: Sequence[Trial]) -> str:
    """Return how many trials of each part were run."""
    run = Counter(a['part'] for a in answers)
    rows = []
    for part in FRESH_PARTS:
        own = [trial for trial in whole if trial.part == part]
        nothing = sum(not trial.names for trial in own)
        rows.append((f'`{part}`', run[part], len(own), nothing))
    return table(('part', 'run', 'drawn', 'of these nothing hidden'), rows)


def by_system(answers: list[Answer]) -> str:
    """Return one row for each kind of system, the whole rig among them."""
    groups = {'whole rig': ('single', 'none', 'parameter'), **{p: (p,) for p in SYSTEM_PARTS}}
    rows = []
    for name, parts in groups.items():
        hidden, nothing = scores.hiding(answers, *parts), scores.null(answers, *parts)
        seconds = [a['seconds'] for a in (*hidden, *nothing) if a['seconds']]
        times = [a['times'] for a in hidden]
        rows.append(
            (
                name.replace('_', ' '),
                _share(hidden, scores.right_first),
                _share(nothing, scores.alarm),
                _share(hidden, places.place_first),
                _share(nothing, lambda a: bool(a['where'])),
                measured('times_f1', middle(places.f1_each(times))),
                f'{median(seconds):.1f}' if seconds else '-',
            )
        )
    head = (
        'system',
        'right name first',
        'nothing hidden: said',
        'right balance first',
        'nothing hidden: listed',
        'median F1 of the intervals',
        'median s',
    )
    return table(head, rows)


def by_group(answers: list[Answer]) -> str:
    """Return how well it is told where, for each group of balances."""
    parts = [part for part in FRESH_PARTS if part != 'uncalibrated']
    hidden, rows = scores.hiding(answers, *parts), []
    for name in places.GROUPS:
        own = [a for a in hidden if places.groups_of(a) == {name}]
        times = [a['times'] for a in own if a['times']['true'] > 0.0]
        rows.append(
            (
                name,
                _share(own, places.place_first),
                _share(own, lambda a: not a['where']),
                measured('times_f1', middle(places.f1_each(times))),
                measured('times_f1', pooled(times, places.f1)),
            )
        )
    head = 'hidden in', 'right balance first', '`where` empty', 'F1, median', 'F1, all together'
    return table(head, rows)


def _share(answers: list[Answer], good: Callable[[Any], bool]) -> str:
    """Return '7 of 9 (45 % to 94 %)', '-' for none."""
    if not answers:
        return '-'
    count = sum(map(good, answers))
    return f'{count} of {len(answers)} ({interval("", share(answers, good))})'


def null_scores(answers: list[Answer]) -> str:
    """Return the z-scores of the residuals where nothing is hidden."""
    nothing = scores.null(answers, *(part for part in FRESH_PARTS if part != 'uncalibrated'))
    rows = []
    for (balance, regime), own in places.null_scores(nothing).items():
        both = pooled(own, places.mean_score), pooled(own, places.rms_score)
        mean, rms = (f'{f["value"]:.2f} ({f["low"]:.2f} to {f["high"]:.2f})' for f in both)
        rows.append((balance, regime, len(own), places.count_of(own), mean, rms))
    return table(('balance', 'regime', 'trials', 'residuals', 'mean', 'RMS'), rows)


def by_effect(answers: list[Answer]) -> str:
    """Return one row an effect: named first, and what else was said."""
    rows = []
    for effect in EFFECTS:
        own = [a for a in scores.seen(answers, 'single') if a['names'] == [effect]]
        right = [a for a in own if scores.named_first(a)]
        errors = [e for a in right for e in a['errors'].values()]
        cuts = [a['cut'] for a in own if a['cut'] is not None]
        rest = Counter(said(a) for a in own if not scores.named_first(a))
        rows.append(
            (
                f'`{effect}`',
                f'{len(right)} of {len(own)}' if own else '-',
                percent(median(cuts)) if cuts else '-',
                percent(median(errors)) if errors else '-',
                ', '.join(f'{name} ({count})' for name, count in rest.most_common()),
            )
        )
    return table(('effect', 'named first', 'gap cut', 'parameter error', 'else said'), rows)
