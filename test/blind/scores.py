"""What the answers are worth: the figures of ``docs/blind.json``, each with its trials."""

from collections.abc import Iterable

from . import places
from .answers import Answer
from .figures import Figure, as_wanted, middle, pooled, share
from .fresh import RIG_PARTS, SYSTEM_PARTS
from .places import balance_of, group
from .trials import NOISES

VISIBLE = 3.0
"""An effect counts as visible that changes a signal by more than this, in multiples of noise."""
NEAR = 1.0
"""The noise of the rig."""
MORE_NOISE = NOISES[1:]
WORKERS = 2

AT_LEAST = {
    'single_top1': (0.95, 'one effect hidden: the right name stands first'),
    'parameter_top1': (0.90, '1 to 3 parameters wrong: `parameter`, a wrong one first'),
    'pairs_both': (0.80, 'two effects hidden: both are named'),
    'triples_all': (0.70, 'three effects hidden: all are named'),
    'unknown_recognised': (0.80, 'the effect is not in the library: `unknown`'),
    'unknown_balance': (0.95, 'of these: the right balance (of a sensor, any)'),
    'uncalibrated_top1': (0.95, 'sensors with errors of gain, one effect: the right name first'),
    'systems_top1': (0.90, 'other systems, one thing hidden: the right name first'),
    'noise_3_top1': (0.94, '3 times the noise, one effect hidden: the right name first'),
    'noise_10_top1': (0.92, '10 times the noise, one effect hidden: the right name first'),
    'heldout_gap_cut': (
        0.80,
        'one effect hidden: median cut of the gap above noise, held-out bags',
    ),
    'interval_coverage': (0.93, 'right name: intervals of 95 % that hold the truth (of so many)'),
    'where_gas': (0.95, 'hidden in the gas: its balance stands first in `where`'),
    'where_force': (0.95, 'hidden in the forces: their balance stands first'),
    'where_sensor': (0.95, 'hidden in a sensor: any balance is listed'),
    'times_f1': (0.90, 'median F1 of the reported intervals'),
    'times_f1_pooled': (0.90, 'F1 of the reported intervals, all trials together'),
}
AT_MOST = {
    'false_alarm': (0.05, 'nothing hidden: false alarms'),
    'uncalibrated_alarm': (0.05, 'sensors with errors of gain, nothing hidden: false alarms'),
    'systems_alarm': (0.05, 'other systems, nothing hidden: false alarms'),
    'noisy_alarm': (0.05, '3 and 10 times the noise, nothing hidden: false alarms'),
    'parameter_error': (0.10, 'median error of the fitted parameters, right name'),
    'where_empty': (0.05, 'something hidden: `where` is empty'),
    'where_missing': (0.00, 'a verdict other than `consistent`: `where` is empty'),
    'null_listings': (0.05, 'nothing hidden: `where` lists something'),
    'seconds_named': (10.00, 'median time to an answer with a name [s]'),
    'seconds_unknown': (60.00, 'median time to the answer `unknown` [s]'),
}
"""
Figure -> what it should be, and what it is; under more noise, what the code before this method
had.
"""
WANTED = as_wanted(AT_LEAST, AT_MOST)
NAMED = ('single', 'parameter', 'unseen', 'uncalibrated', *SYSTEM_PARTS)
"""Parts in which one thing is to be named."""
TIMED = tuple(part for part in RIG_PARTS if part != 'triple')
"""Parts whose times count, as in earlier draws."""


def first_name(answer: Answer) -> str:
    """Return the name that stands first in the answer, '' where none does."""
    named = answer['effects'] if answer['verdict'] == 'effect' else answer['parameters']
    return str(named[0]) if named else ''


def named_first(answer: Answer) -> bool:
    """Whether an effect is the verdict, and the right one stands first."""
    return answer['verdict'] == 'effect' and first_name(answer) in answer['names']


def parameter_first(answer: Answer) -> bool:
    """Whether a parameter is the verdict, and one that is wrong stands first."""
    return answer['verdict'] == 'parameter' and first_name(answer) in answer['names']


def all_named(answer: Answer) -> bool:
    """Whether all hidden effects, whatever else, went into the model."""
    return set(answer['names']) <= set(answer['effects'])


def unknown(answer: Answer) -> bool:
    """Whether the library is said to have no answer."""
    return answer['verdict'] == 'unknown'


def right_balance(answer: Answer) -> bool:
    """Whether the unknown is put on the balance of the removed effect; of a sensor, on any."""
    acts = balance_of(answer['names'][0])
    return acts in ('sensor', group(answer['balance']))


def right_first(answer: Answer) -> bool:
    """Whether what is hidden, an effect, a parameter or nothing, is the verdict."""
    if not answer['names']:
        return not alarm(answer)
    return named_first(answer) or parameter_first(answer)


def placed(answer: Answer) -> bool:
    """Whether it is said to be unknown, and put on the right balance."""
    return unknown(answer) and right_balance(answer)


def alarm(answer: Answer) -> bool:
    """Whether something is said to be missing or wrong; sensors may be that are said to be so."""
    allowed = ('consistent', 'uncalibrated') if uncalibrated(answer) else ('consistent',)
    return answer['verdict'] not in allowed


def uncalibrated(answer: Answer) -> bool:
    """Whether the sensors have errors of gain, of which the model tells."""
    return bool(answer['part'] == 'uncalibrated')


def seen(answers: Iterable[Answer], part: str, noise: float = NEAR) -> list[Answer]:
    """Return the trials of a part at one level of noise in which something is to be seen."""
    return [a for a in answers if a['part'] == part and a['noise'] == noise and shows(a)]


def shows(answer: Answer) -> bool:
    """Whether something is to be seen, or there is nothing hidden."""
    return not answer['names'] or answer['visibility'] > VISIBLE


def figures(answers: list[Answer]) -> dict[str, Figure]:
    """Return the figures: key -> value, number of trials, interval."""
    return {**_names(answers), **_fits(answers), **_places(answers), **_seconds(answers)}


def hiding(answers: Iterable[Answer], *parts: str) -> list[Answer]:
    """Return the trials of parts in which something is hidden that is to be seen."""
    answers = list(answers)
    return [a for part in parts for a in seen(answers, part) if a['names']]


def null(answers: Iterable[Answer], *parts: str) -> list[Answer]:
    """Return the trials of parts in which nothing is hidden."""
    answers = list(answers)
    return [a for part in parts for a in seen(answers, part) if not a['names']]


def _names(answers: list[Answer]) -> dict[str, Figure]:
    removed = seen(answers, 'removed')
    return {
        'single_top1': share(seen(answers, 'single'), named_first),
        'false_alarm': share(seen(answers, 'none'), alarm),
        'parameter_top1': share(seen(answers, 'parameter'), parameter_first),
        'pairs_both': share(seen(answers, 'pair'), all_named),
        'triples_all': share(seen(answers, 'triple'), all_named),
        'unknown_recognised': share(removed, unknown),
        'unknown_balance': share([a for a in removed if unknown(a)], right_balance),
        'uncalibrated_top1': share(hiding(answers, 'uncalibrated'), named_first),
        'uncalibrated_alarm': share(null(answers, 'uncalibrated'), alarm),
        'systems_top1': share(hiding(answers, *SYSTEM_PARTS), right_first),
        'systems_alarm': share(null(answers, *SYSTEM_PARTS), alarm),
        **{
            f'noise_{noise:g}_top1': share(seen(answers, 'single', noise), named_first)
            for noise in MORE_NOISE
        },
        'noisy_alarm': share([a for n in MORE_NOISE for a in seen(answers, 'none', n)], alarm),
    }


def _fits(answers: list[Answer]) -> dict[str, Figure]:
    single = seen(answers, 'single')
    right = [a for a in single if named_first(a)]
    named = [a for part in NAMED for a in seen(answers, part) if right_first(a)]
    covered = [held for a in named for held in a['covered'].values()]
    return {
        'heldout_gap_cut': middle([a['cut'] for a in single if a['cut'] is not None]),
        'parameter_error': middle(
            [error for a in right for error in a['errors'].values()], len(right)
        ),
        'interval_coverage': share(covered, bool),
    }


def _places(answers: list[Answer]) -> dict[str, Figure]:
    # gains that are wrong show in every balance: they say nothing of where an effect is found
    calibrated = [part for part in (*RIG_PARTS, *SYSTEM_PARTS) if part != 'uncalibrated']
    hidden, nothing = hiding(answers, *calibrated), null(answers, *calibrated)
    alone = {name: [a for a in hidden if places.groups_of(a) == {name}] for name in places.GROUPS}
    rows = [a['times'] for a in hidden if a['times']['true'] > 0.0]
    return {
        **{f'where_{name}': share(own, places.place_first) for name, own in alone.items()},
        'where_empty': share(hidden, lambda a: not a['where']),
        'where_missing': share(
            [a for a in (*hidden, *nothing) if a['verdict'] != 'consistent'],
            lambda a: not a['where'],
        ),
        'null_listings': share(nothing, lambda a: bool(a['where'])),
        'times_f1': middle(places.f1_each(rows)),
        'times_f1_pooled': pooled(rows, places.f1),
    }


def _seconds(answers: list[Answer]) -> dict[str, Figure]:
    timed = [
        a
        for a in answers
        if a['seconds'] and a['workers'] == WORKERS and a['part'] in TIMED and a['noise'] == NEAR
    ]
    named = [a['seconds'] for a in timed if a['verdict'] in ('effect', 'parameter')]
    return {
        'seconds_named': middle(named),
        'seconds_unknown': middle([a['seconds'] for a in timed if unknown(a)]),
    }


def reached(name: str, value: float | None) -> bool:
    """Whether a figure is as wanted."""
    wanted = WANTED[name]
    if value is None:
        return False
    return value >= wanted.bound if wanted.sense == 'at least' else value <= wanted.bound
