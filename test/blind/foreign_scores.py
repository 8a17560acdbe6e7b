"""What the answers in a foreign world are worth, a table row for each figure."""

from collections.abc import Iterable
from itertools import pairwise
from statistics import fmean, median

from . import scores
from .answers import Answer
from .figures import Figure, middle, share
from .forms import ALL, mechanism
from .page_tables import figure_row, interval, percent, table

WANTED: dict[str, tuple[str, float]] = {
    'foreign_mechanism': ('at least', 0.85),
    'foreign_cut': ('at least', 0.90),
    'foreign_unknown': ('at least', 0.85),
    'foreign_balance': ('at least', 0.95),
    'unknown_cut': ('at least', 0.90),
    'unknown_least_cut': ('at least', 0.50),
    'nuisance_cause': ('at least', 0.90),
    'nuisance_alarm': ('at most', 0.05),
    'conditions_named': ('at least', 0.90),
    'foreign_pairs_both': ('at least', 0.85),
    'triples_all': ('at least', 0.70),
    'second_mechanism': ('at least', 0.85),
    'second_cut': ('at least', 0.90),
    'second_unknown': ('at least', 0.85),
    'second_balance': ('at least', 0.95),
}
"""What each figure should be."""
MEANING = {
    'foreign_mechanism': 'a foreign form: the right mechanism first, in the verdict',
    'foreign_cut': 'of these: median cut of the gap above noise, held-out bags',
    'foreign_unknown': 'in no library: `unknown`',
    'foreign_balance': 'of these: the right balance (of a sensor, any)',
    'unknown_cut': 'in no library: median cut of the gap above noise, held-out bags',
    'unknown_least_cut': 'in no library: least cut of the gap above noise, held-out bags',
    'nuisance_cause': 'a strong cause among nuisances: it stands first',
    'nuisance_alarm': 'nuisances alone: something strong is said to be missing',
    'conditions_named': 'a wrong condition: named as such',
    'foreign_pairs_both': 'two foreign forms, each visible: both mechanisms are named',
    'triples_all': 'three foreign forms, each visible: all mechanisms are named',
    'second_mechanism': 'a form of the second list: the right mechanism first, in the verdict',
    'second_cut': 'of these: median cut of the gap above noise, held-out bags',
    'second_unknown': 'a form of the second list, in no library: `unknown`',
    'second_balance': 'of these: the right balance (of a sensor, any)',
}
MATCHED = {
    'outward_level': 78,
    'outward_viscous': 78,
    'bent_exhaust_edge': 78,
    'spring_behind_gap': 78,
    'slewing_spool': 80,
    'bump_at_place': 81,
    'outward_excess': 81,
    'sticking_place': 81,
    'small_tank': 82,
    'slow_regulator': 82,
    'quadratic_droop': 84,
    'bowed_position': 87,
}
"""Form that was found missing -> seed from which the library has its formula."""
ALONE = 'foreign', 'foreign_unknown', 'second', 'second_unknown'
"""Parts in which one form is hidden alone."""
PROBABILITIES = 0.0, 0.2, 0.4, 0.6, 0.8, 1.01
"""Ends of the ranges in which stated probabilities are compared with how many answers are true."""


def right_mechanism(answer: Answer) -> bool:
    """Whether the verdict is an effect or a parameter, and the right mechanism stands first."""
    named = answer['verdict'] in ('effect', 'parameter')
    return named and scores.first_name(answer) in mechanism(answer['names'][0])


def all_mechanisms(answer: Answer) -> bool:
    """Whether of each hidden form a right mechanism is in the answer, whatever else is."""
    told = {*answer['effects'], *answer['parameters']}
    return all(told & set(mechanism(name)) for name in answer['names'])


def condition_named(answer: Answer) -> bool:
    """
    Whether a wrong condition is the verdict, and the right one stands first.

    A position beyond the stroke is refused with one line, which has to name the right cylinder.
    """
    if answer['verdict'] == 'refused':
        return answer['names'] == ['cylinder'] and answer['cylinder'] in answer['error']
    told = answer.get('conditions', [])
    return answer['verdict'] == 'conditions' and told[:1] == answer['names']


def alarm(answer: Answer) -> bool:
    """Whether something is said to be missing; the model says that the sensors may be off."""
    return answer['verdict'] not in ('consistent', 'uncalibrated')


def cuts(answers: Iterable[Answer]) -> list[float]:
    """
    Return the held-out cuts; an answer without one has cut nothing.

    Where nothing exceeds the noise of the held-out bags there is nothing to cut.
    """
    return [answer['cut'] or 0.0 for answer in answers if answer['before'] != 0.0]


def figures(answers: list[Answer]) -> dict[str, Figure]:
    """Return key -> value, number of trials, interval, of what is to be seen."""
    foreign, unknown = (foreign_seen(answers, part) for part in ('foreign', 'foreign_unknown'))
    called = [a for a in unknown if scores.unknown(a)]
    least = min(cuts(unknown), default=None)
    return {
        'foreign_mechanism': share(foreign, right_mechanism),
        'foreign_cut': middle(cuts(foreign)),
        'foreign_unknown': share(unknown, scores.unknown),
        'foreign_balance': share(called, scores.right_balance),
        'unknown_cut': middle(cuts(unknown)),
        'unknown_least_cut': {'value': least, 'trials': len(unknown), 'low': None, 'high': None},
        'nuisance_cause': share(scores.seen(answers, 'nuisance'), right_mechanism),
        'nuisance_alarm': share(scores.seen(answers, 'nuisance_none'), alarm),
        'conditions_named': share(scores.seen(answers, 'conditions'), condition_named),
        'foreign_pairs_both': share(all_seen(answers, 'foreign_pairs'), all_mechanisms),
        'triples_all': share(all_seen(answers, 'triples'), all_mechanisms),
        **second_figures(answers),
    }


def second_figures(answers: list[Answer]) -> dict[str, Figure]:
    """Return the figures of the second list of forms, as those of the first."""
    known, unknown = (foreign_seen(answers, part) for part in ('second', 'second_unknown'))
    called = [a for a in unknown if scores.unknown(a)]
    return {
        'second_mechanism': share(known, right_mechanism),
        'second_cut': middle(cuts(known)),
        'second_unknown': share(unknown, scores.unknown),
        'second_balance': share(called, scores.right_balance),
    }


def foreign_seen(answers: list[Answer], part: str) -> list[Answer]:
    """Return the trials of a part with something to be seen, all forms new to the library."""
    return [answer for answer in scores.seen(answers, part) if not _matched(answer)]


def _matched(answer: Answer) -> bool:
    since = [MATCHED[name] for name in answer['names'] if name in MATCHED]
    return bool(since) and int(answer['key'].split('/')[1]) >= min(since)


def all_seen(answers: list[Answer], part: str) -> list[Answer]:
    """Return the trials of a part in which each of several forms is to be seen."""
    seen = foreign_seen(answers, part)
    return [a for a in seen if a['least_visibility'] > scores.VISIBLE]


def headline(answers: list[Answer]) -> str:
    """Return the table of the figures."""
    rows = [
        (*figure_row(name, figure, MEANING[name], WANTED[name]), figure['trials'])
        for name, figure in figures(answers).items()
    ]
    return table(('figure', 'what', 'measured', '95 % interval', 'wanted', 'trials'), rows)


def right(answer: Answer) -> bool:
    """Whether an answer is true, with what it names first, of a trial of any of the parts."""
    verdict = answer['verdict']
    hidden = answer['part'] != 'nuisance_none' and scores.shows(answer)
    if verdict == 'conditions':
        return condition_named(answer)
    if answer['part'] == 'conditions' or not alarm(answer):
        return not (hidden or alarm(answer))
    mechanisms = {each for name in answer['names'] for each in mechanism(name)}
    if verdict == 'unknown':
        return hidden and not mechanisms
    return hidden and scores.first_name(answer) in mechanisms


def by_verdict(answers: list[Answer]) -> str:
    """Return a row for each verdict: how often an answer with it was true."""
    rows = []
    for verdict in sorted({a['verdict'] for a in answers}):
        own = [a for a in answers if a['verdict'] == verdict]
        figure = share(own, right)
        rows.append(
            (
                f'`{verdict}`',
                f'{sum(map(right, own))} of {len(own)}',
                percent(figure['value']),
                interval('right', figure),
            )
        )
    return table(('verdict', 'true', 'share', '95 % interval'), rows)


def by_probability(answers: list[Answer]) -> tuple[str, float | None]:
    """Return a row for each range of stated probabilities, and the calibration error."""
    stated = [a for a in answers if a.get('probability') is not None]
    rows, error = [], 0.0
    for low, high in pairwise(PROBABILITIES):
        own = [a for a in stated if low <= a['probability'] < high]
        if own:
            mean, figure = fmean(a['probability'] for a in own), share(own, right)
            error += len(own) / len(stated) * abs(mean - figure['value'])
            rows.append(
                (
                    f'{low:.2f} to {min(high, 1.0):.2f}',
                    f'{mean:.2f}',
                    f'{sum(map(right, own))} of {len(own)}',
                    percent(figure['value']),
                    interval('right', figure),
                )
            )
    head = 'stated', 'mean', 'true', 'share', '95 % interval'
    return table(head, rows), error if stated else None


def by_form(answers: list[Answer]) -> str:
    """Return a row for each form that was hidden alone: what it was taken for."""
    parts = [a for part in ALONE for a in scores.seen(answers, part)]
    rows = []
    for name in sorted({a['names'][0] for a in parts}):
        own = [a for a in parts if a['names'] == [name]]
        good = sum(right_mechanism(a) or (not mechanism(name) and scores.placed(a)) for a in own)
        answered = ', '.join(scores.first_name(a) or a['verdict'] for a in own)
        cut = median(cuts(own)) if cuts(own) else None
        rows.append(
            (
                f'`{name}`',
                ALL[name].balance,
                ', '.join(mechanism(name)) or '-',
                f'{good} of {len(own)}',
                answered,
                percent(cut),
            )
        )
    return table(('form', 'balance', 'mechanism', 'right', 'answered', 'cut'), rows)
