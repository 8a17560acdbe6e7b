"""What the answers are worth: the figures of ``docs/blind.json``, each with its trials."""

from collections.abc import Callable, Iterable
from statistics import median
from typing import Any

from .answers import Answer

VISIBLE = 3.0
"""An effect counts as visible that changes a signal by more than this, in multiples of noise."""
NEAR = 1.0
"""The noise of the rig."""
PARAMETER_ERROR, GAP_CUT, COVERAGE = 0.10, 0.80, 0.90

WANTED: dict[str, tuple[str, float]] = {
    'single_top1': ('at least', 0.95),
    'false_alarm': ('at most', 0.05),
    'parameter_top1': ('at least', 0.90),
    'pairs_both': ('at least', 0.80),
    'unknown_recognised': ('at least', 0.80),
    'unknown_balance': ('at least', 0.95),
    'unseen_effect': ('at least', 0.95),
    'unseen_parameter': ('at least', 0.90),
    'uncalibrated_top1': ('at least', 0.95),
    'uncalibrated_alarm': ('at most', 0.05),
    'heldout_gap_cut': ('at least', GAP_CUT),
    'parameter_error': ('at most', PARAMETER_ERROR),
    'interval_coverage': ('at least', COVERAGE),
}
"""What each figure should be, at the noise of the rig."""
NAMED = ('single', 'parameter', 'unseen', 'uncalibrated')
"""Parts in which one thing is to be named."""
MEDIANS = ('heldout_gap_cut', 'parameter_error')
"""The figures that are no shares of the trials."""

GAS = {'supply_droop', 'cross_piston_leak', 'chamber_leak', 'valve_null_leak', 'line_lag',
       'wall_heat_transfer', 'valve_lag', 'spool_hysteresis', 'nonlinear_opening'}  # fmt: skip
SENSOR = {'position_scale', 'pressure_offset', 'sensor_delay'}


def balance_of(effect: str) -> str:
    """Return the balance that an effect acts on: gas, force or sensor."""
    return 'gas' if effect in GAS else 'sensor' if effect in SENSOR else 'force'


def group(balance: str) -> str:
    """Return gas, force or sensor for what the workflow calls a balance."""
    words = {'gas': ('gas', 'mass', 'heat', 'supply', 'spool'), 'sensor': ('sensor', 'reading')}
    return next((g for g, marks in words.items() if any(m in balance for m in marks)), 'force')


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


def both_named(answer: Answer) -> bool:
    """Whether all hidden effects, whatever else, went into the model."""
    return set(answer['names']) <= set(answer['effects'])


def unknown(answer: Answer) -> bool:
    """Whether the library is said to have no answer."""
    return answer['verdict'] == 'unknown'


def right_balance(answer: Answer) -> bool:
    """Whether the unknown is put on the balance that the removed effect acts on."""
    return group(answer['balance']) == balance_of(answer['names'][0])


def right_first(answer: Answer) -> bool:
    """Whether what is hidden, an effect, a parameter or nothing, is the verdict."""
    if not answer['names']:
        return not alarm(answer)
    return named_first(answer) or parameter_first(answer)


def placed(answer: Answer) -> bool:
    """Whether it is said to be unknown, and put on the right balance."""
    return unknown(answer) and right_balance(answer)


def alarm(answer: Answer) -> bool:
    """Whether something is said to be missing or wrong."""
    return answer['verdict'] != 'consistent'


def seen(answers: Iterable[Answer], part: str, noise: float = NEAR) -> list[Answer]:
    """Return the trials of a part at one level of noise in which something is to be seen."""
    return [
        a for a in answers
        if a['part'] == part and a['noise'] == noise
        and (not a['names'] or a['visibility'] > VISIBLE)
    ]  # fmt: skip


def share(answers: list[Any], good: Callable[[Any], bool]) -> dict[str, Any]:
    """Return the share of the trials that are good, and their number."""
    value = sum(map(good, answers)) / len(answers) if answers else None
    return {'value': value, 'trials': len(answers)}


def middle(values: list[float], trials: int) -> dict[str, Any]:
    """Return the median, and the number of trials behind it."""
    return {'value': median(values) if values else None, 'trials': trials}


def figures(answers: list[Answer]) -> dict[str, dict[str, Any]]:
    """Return the figures at the noise of the rig: key -> value and number of trials."""
    single, removed, unseen, uncalibrated = (
        seen(answers, part) for part in ('single', 'removed', 'unseen', 'uncalibrated')
    )
    called = [a for a in removed if unknown(a)]
    right = [a for a in single if named_first(a)]
    errors = [error for a in right for error in a['errors'].values()]
    cuts = [a['cut'] for a in single if a['cut'] is not None]
    named = [a for part in NAMED for a in seen(answers, part) if right_first(a)]
    covered = [held for a in named for held in a.get('covered', {}).values()]
    return {
        'single_top1': share(single, named_first),
        'false_alarm': share(seen(answers, 'none'), alarm),
        'parameter_top1': share(seen(answers, 'parameter'), parameter_first),
        'pairs_both': share(seen(answers, 'pair'), both_named),
        'unknown_recognised': share(removed, unknown),
        'unknown_balance': share(called, right_balance),
        'unseen_effect': share([a for a in unseen if a['strength']], right_first),
        'unseen_parameter': share([a for a in unseen if not a['strength']], right_first),
        'uncalibrated_top1': share([a for a in uncalibrated if a['names']], named_first),
        'uncalibrated_alarm': share([a for a in uncalibrated if not a['names']], alarm),
        'heldout_gap_cut': middle(cuts, len(cuts)),
        'parameter_error': middle(errors, len(right)),
        'interval_coverage': share(covered, bool),
    }


def reached(name: str, value: float | None) -> bool:
    """Whether a figure is as wanted."""
    sense, bound = WANTED[name]
    if value is None:
        return False
    return value >= bound if sense == 'at least' else value <= bound
