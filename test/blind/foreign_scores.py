"""What the answers in a foreign world are worth, a table row for each figure."""

from collections.abc import Iterable
from itertools import pairwise
from statistics import fmean, median

from . import scores
from .answers import Answer
from .figures import Figure, as_wanted, middle, share
from .foreign_trials import ALONE
from .forms import ALL, mechanism
from .page_tables import figure_row, interval, percent, table

AT_LEAST = {
    'foreign_mechanism': (0.85, 'a foreign form: the right mechanism first, in the verdict'),
    'foreign_cut': (0.90, 'of these: median cut of the gap above noise, held-out bags'),
    'foreign_unknown': (0.85, 'in no library: `unknown`'),
    'foreign_balance': (0.95, 'of these: the right balance (of a sensor, any)'),
    'unknown_cut': (0.90, 'in no library: median cut of the gap above noise, held-out bags'),
    'unknown_least_cut': (0.50, 'in no library: least cut of the gap above noise, held-out bags'),
    'nuisance_cause': (0.90, 'a strong cause among nuisances: it stands first'),
    'conditions_named': (0.90, 'a wrong condition: named as such'),
    'foreign_pairs_both': (0.85, 'two foreign forms, each visible: both mechanisms are named'),
    'triples_all': (0.70, 'three foreign forms, each visible: all mechanisms are named'),
    'second_mechanism': (
        0.85,
        'a form of the second list: the right mechanism first, in the verdict',
    ),
    'second_cut': (0.90, 'of these: median cut of the gap above noise, held-out bags'),
    'second_unknown': (0.85, 'a form of the second list, in no library: `unknown`'),
    'second_balance': (0.95, 'of these: the right balance (of a sensor, any)'),
}
AT_MOST = {
    'nuisance_alarm': (0.05, 'nuisances alone: something strong is said to be missing'),
}
"""Figure -> what it should be, and what it is."""
WANTED = as_wanted(AT_LEAST, AT_MOST)
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
    'eddy_current_spool': 87,
    'saturating_opening': 93,
    'inflow_heat': 100,
    'stirred_gas_heat': 100,
}
"""Form that was found missing -> seed from which the library has its formula."""
PROBABILITIES = 0.0, 0.2, 0.4, 0.6, 0.8, 1.01
"""Ends of the ranges in which stated probabilities are compared with how many answers are true."""


def seed_of(answer: Answer) -> int:
    """Return the seed from which the trial of an answer was drawn."""
    return int(answer['key'].split('/')[1])


def right_mechanism(answer: Answer) -> bool:
    """Whether the verdict is an effect or a parameter, and the right mechanism stands first."""
    named = answer['verdict'] in ('effect', 'parameter')
    return named and scores.first_name(answer) in mechanism(answer['names'][0])


def all_mechanisms(answer: Answer) -> bool:
    """Whether of each hidden form a right mechanism is in the answer, whatever else is."""
    named = {*answer['effects'], *answer['parameters']}
    return all(named & set(mechanism(name)) for name in answer['names'])


def condition_named(answer: Answer) -> bool:
    """
    Whether a wrong condition is the verdict, and the right one stands first.

    A position beyond the stroke is refused with one line, which has to name the right cylinder.
    """
    if answer['verdict'] == 'refused':
        return answer['names'] == ['cylinder'] and answer['cylinder'] in answer['error']
    conditions = answer.get('conditions', [])
    return answer['verdict'] == 'conditions' and conditions[:1] == answer['names']


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
    unknown = foreign_seen(answers, 'foreign_unknown')
    least = min(cuts(unknown), default=None)
    return {
        **list_figures(answers, 'foreign'),
        'unknown_cut': middle(cuts(unknown)),
        'unknown_least_cut': {'value': least, 'trials': len(unknown), 'low': None, 'high': None},
        'nuisance_cause': share(scores.seen(answers, 'nuisance'), right_mechanism),
        'nuisance_alarm': share(scores.seen(answers, 'nuisance_none'), alarm),
        'conditions_named': share(scores.seen(answers, 'conditions'), condition_named),
        'foreign_pairs_both': share(all_seen(answers, 'foreign_pairs'), all_mechanisms),
        'triples_all': share(all_seen(answers, 'triples'), all_mechanisms),
        **list_figures(answers, 'second'),
    }


def list_figures(answers: list[Answer], forms: str) -> dict[str, Figure]:
    """Return the figures of a list of forms that are hidden alone, ``foreign`` or ``second``."""
    known, unknown = (foreign_seen(answers, part) for part in (forms, f'{forms}_unknown'))
    called = [a for a in unknown if scores.unknown(a)]
    return {
        f'{forms}_mechanism': share(known, right_mechanism),
        f'{forms}_cut': middle(cuts(known)),
        f'{forms}_unknown': share(unknown, scores.unknown),
        f'{forms}_balance': share(called, scores.right_balance),
    }


def foreign_seen(answers: list[Answer], part: str) -> list[Answer]:
    """Return the trials of a part with something to be seen, all forms new to the library."""
    return [answer for answer in scores.seen(answers, part) if not _matched(answer)]


def _matched(answer: Answer) -> bool:
    since = [MATCHED[name] for name in answer['names'] if name in MATCHED]
    return bool(since) and seed_of(answer) >= min(since)


def all_seen(answers: list[Answer], part: str) -> list[Answer]:
    """Return the trials of a part in which each of several forms is to be seen."""
    seen = foreign_seen(answers, part)
    return [a for a in seen if a['least_visibility'] > scores.VISIBLE]


def headline(answers: list[Answer]) -> str:
    """Return the table of the figures."""
    rows = [
        (*figure_row(name, figure, WANTED[name]), figure['trials'])
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
