"""The answers that are wrong, each with the way in which it is."""

from . import scores
from .answers import Answer
from .fresh import FRESH_PARTS
from .page_tables import percent, table

JUDGES = {
    'single': scores.named_first,
    'parameter': scores.parameter_first,
    'pair': scores.all_named,
    'triple': scores.all_named,
    'removed': scores.placed,
}
"""Part -> what a right answer is; the right name first in the others."""


def misses(answers: list[Answer]) -> str:
    """Return every wrong answer at the noise of the rig."""
    rows = []
    for part in FRESH_PARTS:
        good = JUDGES.get(part, scores.right_first)
        for a in scores.seen(answers, part):
            if not good(a):
                answer = a['error'] or ', '.join([*a['effects'], *a['parameters']]) or '-'
                rows.append(
                    (
                        f'`{a["key"]}`',
                        a['strength'] or '-',
                        f'{a["visibility"]:.0f}',
                        a['verdict'],
                        answer,
                        ', '.join(a['ranking'][:3]),
                        percent(a['cut']),
                        kind(a),
                    )
                )
    rows.sort()
    head = 'trial', 'grade', 'visibility', 'verdict', 'added', 'ranked', 'cut', 'kind'
    return table(head, rows)


def kind(answer: Answer) -> str:
    """Return in which way an answer is wrong."""
    right = set(answer['names'])
    told = {*answer['effects'], *answer['parameters']}
    ways = {
        'the workflow failed': answer['verdict'] == 'crashed',
        'reported as indistinguishable from the right one': any(
            right & {n for row in alike for n in row.split('+')} for alike in answer['alike']
        ),
        f'put on another balance: {answer["balance"]}': answer['part'] == 'removed'
        and scores.unknown(answer),
        'another one takes its place': answer['part'] == 'removed'
        and answer['verdict'] in ('effect', 'parameter'),
        'found, but not first': bool(right) and right <= told,
        'judged consistent': bool(right) and answer['verdict'] == 'consistent',
        'one found, not all': bool(right & told),
        'ranked, another fits better': bool(
            right & {name for row in answer['ranking'] for name in row.split('+')}
        ),
        'another takes its place': bool(right),
    }
    return next((way for way, holds in ways.items() if holds), 'fits noise')
