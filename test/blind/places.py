"""What the answers say of where the model fails, against where what is hidden shows."""

from collections.abc import Iterable, Sequence
from typing import Any

from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.effect import GAS_BALANCES, READING_BALANCES
from pneu_rig_ros.scenarios.hidden import EFFECTS

from .circumstances import WRONG
from .forms import ALL
from .runs import Truth
from .windows import length, shared

Answer = dict[str, Any]
Score = dict[str, Any]
"""Balance, regime, and the mean, RMS and count of its z-scores."""
GAS = {name for name in EFFECTS if library.load(name).balance in GAS_BALANCES}
SENSOR = {name for name in EFFECTS if library.load(name).balance in READING_BALANCES}
GROUPS = ('gas', 'force', 'sensor')
OF_FORCE = ('friction.', 'cylinder.moving_mass')
"""How the parameters of the forces begin; the others are of the gas."""


def balance_of(name: str) -> str:
    """Return the balance that an effect or parameter acts on: gas, force or sensor."""
    if name in ALL:
        return ALL[name].balance
    if name in WRONG:
        return WRONG[name]
    if '.' in name:
        return 'force' if name.startswith(OF_FORCE) else 'gas'
    return 'gas' if name in GAS else 'sensor' if name in SENSOR else 'force'


def group(balance: str) -> str:
    """Return gas, force or sensor for what the workflow calls a balance."""
    words = {'gas': ('gas', 'mass', 'heat', 'supply', 'spool'), 'sensor': ('sensor', 'reading')}
    return next((g for g, marks in words.items() if any(m in balance for m in marks)), 'force')


def place_first(answer: Answer) -> bool:
    """Whether the balance that stands first is the hidden one; of a sensor any may be."""
    where = answer['where']
    if not where:
        return False
    return 'sensor' in groups_of(answer) or group(where[0]) in groups_of(answer)


def groups_of(answer: Answer) -> set[str]:
    """Return the groups of balances on which what is hidden acts."""
    return {balance_of(name) for name in answer['names']}


def times(names: Sequence[str], truth: Truth, told: Iterable[dict[str, Any]]) -> dict[str, float]:
    """
    Return how long what is hidden shows, how long the answer says so, and how long both do [s].

    The balances of a group count together; of a sensor, all do. Recordings that were not for the
    fit are left out.
    """
    wanted = {balance_of(name) for name in names}
    told = list(told)
    sums = {'true': 0.0, 'told': 0.0, 'shared': 0.0}
    for one in [('gas', 'force')] if 'sensor' in wanted else [(name,) for name in wanted]:
        for recording in {name for spans in truth.values() for name in spans}:
            real = [
                span
                for balance, spans in truth.items()
                if group(balance) in one
                for span in spans[recording]
            ]
            said = [
                (row['from'], row['to'])
                for row in told
                if row['recording'] == recording and group(row['balance']) in one
            ]
            sums['true'] += length(real)
            sums['told'] += length(said)
            sums['shared'] += shared(real, said)
    return sums


def f1(rows: Sequence[dict[str, float]]) -> float | None:
    """Return F1 of the times of answers, taken together; None where nothing shows."""
    true, told, both = (sum(row[key] for row in rows) for key in ('true', 'told', 'shared'))
    return 2.0 * both / (true + told) if true > 0.0 else None


def f1_each(rows: Sequence[dict[str, float]]) -> list[float]:
    """Return F1 of each answer in which something shows."""
    return [value for row in rows if (value := f1([row])) is not None]


def null_scores(answers: Iterable[Answer]) -> dict[tuple[str, str], list[Score]]:
    """Return (balance, regime) -> z-scores of each answer, where nothing is hidden."""
    found: dict[tuple[str, str], list[Score]] = {}
    for answer in answers:
        for row in answer['null_scores']:
            found.setdefault((row['balance'], row['regime']), []).append(row)
    return dict(sorted(found.items()))


def mean_score(rows: Sequence[Score]) -> float:
    """Return the mean of the z-scores of answers, each residual counted once."""
    return float(sum(row['count'] * row['mean'] for row in rows) / count_of(rows))


def rms_score(rows: Sequence[Score]) -> float:
    """Return the root mean square of the z-scores of answers, each residual counted once."""
    return float((sum(row['count'] * row['rms'] ** 2 for row in rows) / count_of(rows)) ** 0.5)


def count_of(rows: Sequence[Score]) -> int:
    """Return the number of residuals."""
    return int(sum(row['count'] for row in rows))
