"""``docs/blind.md``, ``docs/blind.json`` and the picture: written from the answers alone."""

import json
import textwrap
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from scipy.stats import binomtest

from . import scores
from .answers import Answer
from .confusion import draw, said
from .hidden import CYLINDERS, EFFECTS, STRENGTHS
from .trials import NOISES, PARTS, matrix

PICTURE = 'images/blind.png'
LEAST_CUT = 0.05
"""A formula that cuts less of the gap hardly describes it [-]."""
MEANING = {
    'single_top1': 'one effect hidden: the right name stands first',
    'false_alarm': 'nothing hidden: something is said to be missing',
    'parameter_top1': '1 to 3 parameters wrong: `parameter`, a wrong one first',
    'pairs_both': 'two effects hidden: both are named',
    'unknown_recognised': 'the effect is not in the library: `unknown`',
    'unknown_balance': 'of these: the right balance',
    'unseen_effect': 'one effect of a strength drawn: the right name stands first',
    'unseen_parameter': 'one parameter wrong: `parameter`, the right one first',
    'uncalibrated_top1': 'sensors with errors of gain, one effect: the right name first',
    'uncalibrated_alarm': 'sensors with errors of gain, nothing hidden: something is said',
    'heldout_gap_cut': 'one effect hidden: median cut of the gap above noise, bags left out',
    'parameter_error': 'median error of the fitted parameters, right name',
    'interval_coverage': 'right name: intervals of 95 % that hold the truth (of so many)',
}
BASELINES = {
    'refit': 'all parameters fitted, nothing added',
    'sparse': 'sparse regression of the residuals (pysindy)',
    'black box': 'network that learns the gap (scikit-learn)',
}
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


def ratio(answers: list[Answer], good: Any) -> str:
    """Return '7 of 9', '-' for none."""
    return f'{sum(map(good, answers))} of {len(answers)}' if answers else '-'


def headline(answers: list[Answer]) -> str:
    """Return the table of the wanted figures."""
    rows = []
    for name, figure in scores.figures(answers).items():
        sense, bound = scores.WANTED[name]
        mark = REACHED[scores.reached(name, figure['value'])] if figure['trials'] else '-'
        rows.append((
            f'`{name}`', MEANING[name], percent(figure['value'], 1), interval(name, figure),
            f'{sense} {bound:.0%}', mark, figure['trials'],
        ))  # fmt: skip
    head = 'figure', 'what', 'measured', '95 % interval', 'wanted', 'reached', 'trials'
    return table(head, rows)


def interval(name: str, figure: dict[str, Any]) -> str:
    """Return Wilson's interval of a share; a median has none here."""
    if name in scores.MEDIANS or not figure['trials']:
        return '-'
    good = round(figure['value'] * figure['trials'])
    bounds = binomtest(good, figure['trials']).proportion_ci(method='wilson')
    return f'{percent(bounds.low)} to {percent(bounds.high)}'


def coverage(answers: list[Answer]) -> str:
    """Return how much of the matrix was run."""
    whole = Counter((t.part, t.noise) for t in matrix())
    run = Counter((a['part'], a['noise']) for a in answers)
    rows = [
        (part, *(f'{run[part, n]} of {whole[part, n]}' if whole[part, n] else '' for n in NOISES))
        for part in PARTS
    ]
    return table(('part', *(f'noise x {noise:g}' for noise in NOISES)), rows)


def by_effect(answers: list[Answer]) -> str:
    """Return one row an effect: named first, at each noise, and what else was said."""
    rows = []
    for effect in EFFECTS:
        own = [a for a in answers if a['part'] == 'single' and a['names'] == [effect]]
        cells = [ratio(scores.seen(own, 'single', noise), scores.named_first) for noise in NOISES]
        near = scores.seen(own, 'single')
        right = [a for a in near if scores.named_first(a)]
        errors = [e for a in right for e in a['errors'].values()]
        cuts = [a['cut'] for a in near if a['cut'] is not None]
        rest = Counter(said(a) for a in near if not scores.named_first(a))
        rows.append((
            f'`{effect}`', *cells, percent(median(cuts)) if cuts else '-',
            percent(median(errors)) if errors else '-',
            ', '.join(f'{name} ({count})' for name, count in rest.most_common()),
        ))  # fmt: skip
    head = 'effect', *(f'named first, noise x {n:g}' for n in NOISES)
    return table((*head, 'gap cut', 'parameter error', 'else said (noise x 1)'), rows)


def by_strength(answers: list[Answer]) -> str:
    """Return named first by strength and cylinder, noise of the rig."""
    single = scores.seen(answers, 'single')
    rows = [
        (strength, *(
            ratio(
                [a for a in single if (a['strength'], a['cylinder']) == (strength, cylinder)],
                scores.named_first,
            )
            for cylinder in CYLINDERS
        ))
        for strength in STRENGTHS
    ]  # fmt: skip
    return table(('', *CYLINDERS), rows)


def by_method(answers: list[Answer]) -> str:
    """Return the gap that each baseline cuts on the trials in which it was tried."""
    compared = [a for a in scores.seen(answers, 'single') if a['baselines']]
    ours = [a['cut'] for a in compared]
    rows = [('this workflow', *_spread(ours), ratio(compared, scores.named_first))]
    for name, meaning in BASELINES.items():
        rows.append((meaning, *_spread([a['baselines'][name] for a in compared]), 'names nothing'))
    head = 'method', 'median cut of the gap', 'quartiles', 'trials', 'right name'
    return table(head, rows)


def _spread(cuts: list[float]) -> tuple[str, str, int]:
    if not cuts:
        return '-', '-', 0
    low, middle, high = np.percentile(cuts, (25.0, 50.0, 75.0))
    return percent(middle), f'{percent(low)} to {percent(high)}', len(cuts)


def misses(answers: list[Answer]) -> str:
    """Return every wrong answer at the noise of the rig."""
    judges = {
        'single': scores.named_first, 'parameter': scores.parameter_first,
        'pair': scores.both_named, 'removed': scores.placed,
    }  # fmt: skip
    rows = []
    for part in PARTS:
        good = judges.get(part, scores.right_first)
        for a in scores.seen(answers, part):
            if not good(a):
                answer = a['error'] or ', '.join([*a['effects'], *a['parameters']]) or '-'
                first = ', '.join(a['ranking'][:3])
                rows.append((
                    f'`{a["key"]}`', f'{a["visibility"]:.0f}', a['verdict'], answer, first,
                    percent(a['cut']) if a['cut'] is not None else '-', kind(a),
                ))  # fmt: skip
    rows.sort()
    return table(('trial', 'visibility', 'verdict', 'added', 'ranked', 'cut', 'kind'), rows)


def kind(answer: Answer) -> str:
    """Return in which way an answer is wrong."""
    right = set(answer['names'])
    if answer['verdict'] == 'crashed':
        return 'the workflow failed'
    if any(right & {n for row in alike for n in row.split('+')} for alike in answer['alike']):
        return 'said to be inseparable from the right one on these bags'
    if answer['part'] == 'removed' and scores.unknown(answer):
        return f'put on another balance: {answer["balance"]}'
    if answer['part'] == 'removed' and answer['verdict'] in ('effect', 'parameter'):
        return 'another one takes its place'
    if right and right <= {*answer['effects'], *answer['parameters']}:
        return 'found, but not first'
    if answer['verdict'] == 'consistent':
        return 'held to be within the noise' if right else ''
    if right & {*answer['effects'], *answer['parameters']}:
        return 'one found, not all'
    if right & {name for row in answer['ranking'] for name in row.split('+')}:
        return 'ranked, another fits better'
    return 'another takes its place' if right else 'fits noise'


def as_json(answers: list[Answer]) -> dict[str, Any]:
    """Return the content of ``docs/blind.json``."""
    whole = matrix()
    seconds = [a['seconds'] for a in answers if a['seconds']]
    wider = {
        f'single_top1_noise_{noise:g}': scores.share(
            scores.seen(answers, 'single', noise), scores.named_first
        )
        for noise in NOISES[1:]
    }
    return {
        **scores.figures(answers),
        **wider,
        'matrix': {'run': len(answers), 'trials': len(whole)},
        'seconds': scores.middle(seconds, len(seconds)),
    }


TEXT = """# Blind trials

Written by `make blind`. The workflow of `pneu-rig diagnose` gets six bags and a model file and
nothing else; bags come from a second plant (`test/blind/plant.py`: SciPy's LSODA, none of the
package's model code) through 12-bit sensors with noise. Their slopes are right and the model says
so; in the part `uncalibrated` they are wrong within the accuracy class of the shipped sensors
(0.5 % of position, 1 % of pressure), and the model tells that. What is hidden where is told in
`test/blind/hidden.py` and `test/blind/trials.py`. {run} of {whole} trials of the matrix were run,
{seconds} s each (median, one processor), at git {revisions}. Their order hangs on a hash of their
names alone, the noise of the rig first: in each part those that were run are a fair sample. Every
answer is a line of `docs/blind_answers.jsonl`; `make blind` goes on from there. Intervals are
counted in answers that have `covered`; those of earlier ones were too narrow.
What earlier revisions missed was looked into and its cause mended, so those trials are no longer
blind; they are counted like all others. Those of the part `unseen` were drawn and run once, later:
nothing was changed for the sake of what they name.

Figures are for the noise of the rig and for trials in which what is hidden changes a signal by
more than {visible:g} times the noise (root mean square over the bags); {dim} trials show less and
are not counted.

{headline}
{described}
Those that cut less than 70 % were mostly sought again when there were more terms to choose from.

## How much of the matrix was run

{coverage}
## What is hidden, and what is answered

![Confusion table](images/blind.png)

*Counts at the noise of the rig; a row for what is hidden, a column for what stands first.*

{by_effect}
Named first, at the noise of the rig, by strength and cylinder:

{by_strength}
## Against what one would do without it

The same bags, predictions and noise floors; share of the gap above noise that is cut on bags left
out of the fit. Medium strength, noise of the rig; `test/blind/baselines.py`.

{by_method}
## Misses at the noise of the rig

{misses}"""


def described(answers: list[Answer]) -> str:
    """Return how far descriptions of removed effects cut the gap, and of which they hardly do."""
    removed = [a for a in scores.seen(answers, 'removed') if scores.unknown(a)]
    removed = [a for a in removed if a['cut'] is not None]
    middle, quartiles, count = _spread([a['cut'] for a in removed])
    least = [a for a in removed if a['cut'] < LEAST_CUT]
    trials = ', '.join(f'`{a["names"][0]}` ({a["cylinder"][-1]})' for a in least)
    text = (
        'An effect that is said to be unknown is described by a formula, which cuts the gap above '
        f'noise, on bags left out of the fit, by {middle} (median of {count}; quartiles '
        f'{quartiles}).'
    )
    hardly = f' By less than {percent(LEAST_CUT)} in {len(least)}, effect (cylinder): {trials}.'
    return textwrap.fill(text + (hardly if least else ''), 99)


def revisions(answers: list[Answer]) -> str:
    """Return which revisions of the workflow answered."""
    names = sorted({a['revision'] for a in answers})
    return f'revision{"s" if len(names) > 1 else ""} {", ".join(names) or "-"}'


def write(answers: list[Answer], docs: Path) -> None:
    """Write the page, the figures and the picture into a folder."""
    whole = matrix()
    hidden = [a for a in answers if a['names'] and a['noise'] == scores.NEAR]
    seconds = [a['seconds'] for a in answers if a['seconds']]
    text = TEXT.format(
        revisions=revisions(answers),
        run=len(answers), whole=len(whole), seconds=f'{median(seconds):.0f}' if seconds else '-',
        visible=scores.VISIBLE, dim=sum(a['visibility'] <= scores.VISIBLE for a in hidden),
        headline=headline(answers), described=described(answers), coverage=coverage(answers),
        by_effect=by_effect(answers), by_strength=by_strength(answers),
        by_method=by_method(answers), misses=misses(answers),
    )  # fmt: skip
    draw(answers, docs / PICTURE)
    (docs / 'blind.md').write_text(text)
    (docs / 'blind.json').write_text(json.dumps(as_json(answers), indent=2) + '\n')
