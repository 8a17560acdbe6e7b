"""The wrong answers of a foreign world by their kind, and the right ones by draw."""

from collections import Counter, defaultdict
from collections.abc import Callable

from . import scores
from .answers import Answer
from .foreign_scores import (
    alarm,
    all_mechanisms,
    all_seen,
    condition_named,
    foreign_seen,
    right_mechanism,
)
from .forms import mechanism
from .page_tables import percent, table

CLOSES = 0.9
"""Share of the gap from which on an answer closes it [-]: what is wanted of right ones."""


def by_kind(answers: list[Answer]) -> str:
    """Return a row for each part and kind of wrong answer, with what was hidden in them."""
    rows = []
    for part, (counted, right) in judged(answers).items():
        wrong = [a for a in counted if not right(a)]
        forms: dict[str, Counter[str]] = defaultdict(Counter)
        for answer in wrong:
            forms[kind(answer)]['+'.join(answer['names']) or 'nothing'] += 1
        for name, hidden in sorted(forms.items(), key=lambda pair: -pair[1].total()):
            listed = ', '.join(f'`{form}`' + f' x {n}' * (n > 1) for form, n in hidden.items())
            rows.append((f'`{part}`', name, f'{hidden.total()} of {len(counted)}', listed))
    return table(('part', 'kind', 'wrong', 'hidden'), rows)


def by_draw(answers: list[Answer]) -> str:
    """Return a row for each seed: in each part, how many of the visible trials are right."""
    seeds = sorted({seed_of(a) for a in answers})
    parts = judged(answers)
    rows = []
    for seed in seeds:
        cells = []
        for counted, right in parts.values():
            own = [a for a in counted if seed_of(a) == seed]
            cells.append(f'{sum(map(right, own))} of {len(own)}' if own else '-')
        rows.append((str(seed), *cells))
    return table(('seed', *(f'`{part}`' for part in parts)), rows)


def judged(answers: list[Answer]) -> dict[str, tuple[list[Answer], Callable[[Answer], bool]]]:
    """Return part -> the answers that count, and what a right one is."""
    return {
        'foreign': (foreign_seen(answers, 'foreign'), right_mechanism),
        'foreign_unknown': (foreign_seen(answers, 'foreign_unknown'), scores.unknown),
        'nuisance': (scores.seen(answers, 'nuisance'), right_mechanism),
        'nuisance_none': (scores.seen(answers, 'nuisance_none'), lambda a: not alarm(a)),
        'conditions': (scores.seen(answers, 'conditions'), condition_named),
        'foreign_pairs': (all_seen(answers, 'foreign_pairs'), all_mechanisms),
        'triples': (all_seen(answers, 'triples'), all_mechanisms),
        'second': (foreign_seen(answers, 'second'), right_mechanism),
        'second_unknown': (foreign_seen(answers, 'second_unknown'), scores.unknown),
    }


def kind(answer: Answer) -> str:
    """Return in which way an answer is wrong."""
    verdict, mechanisms = answer['verdict'], {m for n in answer['names'] for m in mechanism(n)}
    first = answer['ranking'][0] if answer['ranking'] else ''
    ranked = {each.split(' over ')[0] for each in first.split('+')}
    if verdict in ('consistent', 'uncalibrated', 'crashed', 'refused'):
        return f'`{verdict}`'
    if verdict == 'unknown':
        return '`unknown`, ' + ('a right cause' if ranked & mechanisms else 'another') + ' first'
    if mechanisms & {*answer['effects'], *answer['parameters']}:
        return 'a right cause is named, not first or not all'
    if answer['before'] == 0.0 or answer['cut'] is None:
        return 'another cause, no gap on the held-out recordings'
    much = '' if answer['cut'] >= CLOSES else 'less than '
    return f'another cause, which closes {much}{percent(CLOSES)} of the gap'


def seed_of(answer: Answer) -> int:
    """Return the seed from which the trial of an answer was drawn."""
    return int(answer['key'].split('/')[1])
