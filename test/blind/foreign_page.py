"""``docs/blind_foreign.md`` and ``docs/blind_foreign.json``, written from the answers alone."""

import json
from collections import Counter, defaultdict
from collections.abc import Callable
from pathlib import Path

from . import scores
from .answers import FOLDER, Answer
from .foreign import FORMS, KNOWN, UNKNOWN
from .foreign_scores import (
    MATCHED,
    alarm,
    all_mechanisms,
    all_seen,
    by_form,
    by_probability,
    by_verdict,
    condition_named,
    figures,
    foreign_seen,
    headline,
    right_mechanism,
    seed_of,
)
from .foreign_trials import FOREIGN_PARTS, SECOND_PARTS, drawn_foreign
from .forms import mechanism
from .page_tables import percent, table
from .second import SECOND_KNOWN, SECOND_UNKNOWN

NAME = 'blind_foreign'
CLOSES = 0.9
"""Share of the gap from which on an answer closes it [-]: what is wanted of right ones."""
SINCE = {'nuisance': 63, 'nuisance_none': 63}
"""
Part -> first seed that counts: before, strong causes were weaker, and the answers were looked at
while the rule for weak effects was set.
"""
TEXT = """# Blind trials in a foreign world

Written by `make blind ARGS='--part foreign_world'`. The second plant of these trials has laws that
differ from those of the library: {forms} forms, {known} of a mechanism that the library has under
another formula, {unknown} of none that it has (`test/blind/foreign.py`). The other parts add weak
nuisances, conditions that are not as stated, and two or three forms at a time.

The trials were drawn afresh, strengths, shapes and cylinders, and run once, those of a seed by the
[revision of its day](#by-draw), in an order in which any first part is a fair sample, for as long
as there was time. Of {since} only trials from seed 63 on count: strong causes were weaker
before, and earlier answers were looked at while the rule for weak effects was set. A strong cause
among nuisances is drawn from the stronger half of the strengths of its form, and is visible if it
alone changes a signal by 3 times the noise. The list of forms is the one from which the trials for
building were drawn, with other seeds. Formulas that were found missing are in the library since:
as foreign forms they do not count from these seeds on: {matched}.

The parts `second` and `second_unknown` have forms of a second list: {second_known} of a mechanism
that the library has, {second_unknown} of none (`test/blind/second.py`). It was written after the
library, from the literature alone; its first draw, seed 86, judges a revision that was built
without any trial of it.

Every answer is a line of the file of its revision in `docs/{folder}`. Recordings, sensors and what
is counted are as in [Blind trials](blind.md).

{headline}
## How much was run

{coverage}
## What an answer is worth

How often an answer was true, by its verdict, in all of these trials: a name that is a right
mechanism, `unknown` where the library has none, nothing missing where nothing strong or visible
is hidden. Another mix of causes than that of these trials has other shares.

{by_verdict}
{reliability}## By draw

Right answers of those that count. Between draws the method was built further, and what the misses
showed went into it.

{by_draw}
## Wrong answers by kind

{by_kind}
## Form by form

{by_form}
## Answers

Right is - where a trial does not count: it shows nothing, or not by each of its causes, or its
form is in the library since.

{answers}"""
COUNTED = range(77, 87)
"""Seeds that gave the stated probabilities; on later ones these are judged."""
RELIABILITY = """Each answer says how probable it is: the share of its verdict of seeds {first} to
{last}, of systems with exact sensors or of those known to their class only, and of a name its
weight among what was fitted beside it (`diagnosis/answer/alternatives.py`). Of {count} answers to
later seeds, which had no part in that, the expected calibration error is {error:.2f}:

{table}
"""


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


def by_draw(by_revision: dict[str, list[Answer]]) -> str:
    """Return a row for each draw: in each part, how many of the visible trials are right."""
    rows = []
    for seed, revision in draws(by_revision):
        drawn = [each for each in by_revision[revision] if seed_of(each) == seed]
        cells = [
            f'{sum(map(right, counted))} of {len(counted)}' if counted else '-'
            for counted, right in judged(drawn).values()
        ]
        rows.append((str(seed), revision, *cells))
    return table(('seed', 'git', *(f'`{part}`' for part in judged([]))), rows)


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


def reliability(answers: list[Answer]) -> str:
    """Return how often answers were true by what they say; nothing where none says it."""
    later = [a for a in answers if seed_of(a) >= COUNTED.stop]
    rows, error = by_probability(later)
    if error is None:
        return ''
    return RELIABILITY.format(
        first=COUNTED[0], last=COUNTED[-1], count=len(later), error=error, table=rows
    )


def coverage(answers: list[Answer], seeds: list[int]) -> str:
    """Return how many trials of each part were run, and in how many something shows."""
    rows = []
    for part in FOREIGN_PARTS:
        own = [a for a in answers if a['part'] == part]
        shown = sum(scores.shows(a) for a in own)
        counted = [seed for seed in seeds if counts(part, seed, own)]
        drawn = sum(len(drawn_foreign(seed, (part,))) for seed in counted)
        rows.append((f'`{part}`', len(own), drawn, shown))
    return table(('part', 'run', 'drawn', 'visible'), rows)


def counts(part: str, seed: int, own: list[Answer]) -> bool:
    """Whether a draw has a part that counts; of the second list, where it was run at all."""
    if part in SECOND_PARTS:
        return any(seed_of(answer) == seed for answer in own)
    return seed >= SINCE.get(part, 0)


def draws(by_revision: dict[str, list[Answer]]) -> list[tuple[int, str]]:
    """Return the seeds and revisions of all answers."""
    found = ((seed_of(each), name) for name, own in by_revision.items() for each in own)
    return sorted(set(found))


def said(answers: list[Answer]) -> str:
    """Return a row for each answer."""
    marks = {
        id(a): 'yes' if right(a) else 'no'
        for counted, right in judged(answers).values()
        for a in counted
    }
    rows = sorted(
        (
            f'`{a["key"]}`',
            marks.get(id(a), '-'),
            f'{a["visibility"]:.0f}',
            a['verdict'],
            a['error'] or ', '.join([*a['effects'], *a['parameters'], *a['conditions']]) or '-',
            ', '.join(a['ranking'][:3]) or '-',
            percent(a['cut']),
            f'{a["seconds"]:.0f}',
        )
        for a in answers
    )
    head = 'trial', 'right', 'visibility', 'verdict', 'named', 'ranked', 'cut', 's'
    return table(head, rows)


def kept_answers(source: Path) -> dict[str, list[Answer]]:
    """Return revision -> its answers that count, from the folder with those of each revision."""
    found = {}
    for store in sorted(source.glob('*_foreign.jsonl')):
        answers = [json.loads(line) for line in store.read_text().splitlines()]
        counted = [each for each in answers if seed_of(each) >= SINCE.get(each['part'], 0)]
        found[store.stem.removesuffix('_foreign')] = counted
    return found


def write_kept(source: Path, docs: Path) -> None:
    """
    Write the page from all answers that are kept.

    :param source: folder with the answers of each revision
    """
    by_revision = kept_answers(source)
    answers = [each for found in by_revision.values() for each in found]
    drawn = draws(by_revision)
    text = TEXT.format(
        since=', '.join(f'`{part}`' for part in SINCE),
        matched=', '.join(f'`{form}` {seed}' for form, seed in MATCHED.items()),
        forms=len(FORMS),
        known=len(KNOWN),
        unknown=len(UNKNOWN),
        second_known=len(SECOND_KNOWN),
        second_unknown=len(SECOND_UNKNOWN),
        folder=FOLDER,
        headline=headline(answers),
        coverage=coverage(answers, [seed for seed, _ in drawn]),
        by_draw=by_draw(by_revision),
        by_kind=by_kind(answers),
        by_form=by_form(answers),
        by_verdict=by_verdict(answers),
        reliability=reliability(answers),
        answers=said(answers),
    )
    (docs / f'{NAME}.md').write_text(text)
    data = {**figures(answers), 'draws': [{'seed': s, 'revision': r} for s, r in drawn]}
    (docs / f'{NAME}.json').write_text(json.dumps(data, indent=2) + '\n')
