"""``docs/blind.md``, ``docs/blind.json`` and the picture: written from the answers alone."""

import json
import textwrap
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from . import scores
from .answers import FOLDER, Answer, kept
from .confusion import draw
from .fresh import EARLIER, FRESH_PARTS, SEED, drawn
from .page_tables import (
    by_effect,
    by_group,
    by_system,
    comparison,
    coverage,
    headline,
    null_scores,
    percent,
    table,
)

PICTURE = 'images/blind.png'
JUDGES = {
    'single': scores.named_first,
    'parameter': scores.parameter_first,
    'pair': scores.all_named,
    'triple': scores.all_named,
    'removed': scores.placed,
}
"""Part -> what a right answer is; the right name first in the others."""
LEAST_CUT = 0.05
"""A formula that cuts less of the gap hardly describes it [-]."""

TEXT = """# Blind trials

Written by `make blind`. The second plant of these trials shares the functional forms of the
library: an effect that is hidden has the formula under which the library knows it. Laws with
other formulas are hidden in [a foreign world](blind_foreign.md). Trials that were looked at while
the workflow was built are not blind; those reported here were drawn afresh, strengths, cylinders
and sizes of the systems, from seed {seed}, and run once, at git {ran_at}.

The workflow of `pneu-rig diagnose` gets recordings and a model file and nothing else. Recordings
come from a second plant (`test/blind`: SciPy's LSODA, for gas alone Runge-Kutta; none of the
package's model code) through 12-bit sensors with noise. Their slopes are right and the model says
so; in the part `uncalibrated` they are wrong within the accuracy class of the shipped sensors
(0.5 % of position, 1 % of pressure), and the model states that. What can be hidden in a rig, and
how strong, is in `pneu_rig_ros/scenarios/hidden.py`, in the other systems in `sealed.py` (sealed
chambers, one leaking chamber), `bench.py` (a seal) and `block.py` (valves into fixed volumes);
`one_pressure` is a rig whose second pressure is not measured. {run} of {whole} trials were run.
Every answer is a line of `docs/{folder}/{revision}.jsonl`; `make blind` goes on from there.

Counted are trials in which what is hidden changes a signal by more than {visible:g} times the
noise (root mean square over the recordings); those below: {dim}. Shares have Wilson's
interval, medians that of the binomial distribution of ranks, what is pooled that of resampling.
Figures are at the noise of the rig but for those of 3 and 10 times as much, which are wanted as
good as those of the code before the present method (169 of 179 and 117 of 127 on another matrix).
Its figures `unseen_effect` and `unseen_parameter` are part of `single_top1` and `parameter_top1`,
as all strengths are drawn.
Times are of whole rigs, six bags, two workers.

{headline}
{described}
{comparison}## How much was run

{coverage}
## By system

{by_system}
## Where

An interval is true where the contribution of what is hidden to a balance - computed by the second
plant along the noise-free run, averaged in a window of 0.1 s (gas) or 70 ms (forces), 20 samples
at least - exceeds one standard deviation of what the noise of the sensors makes of that window.
Reported intervals are compared with these over all recordings of the fit, the balances of a group
together; of sensors, all balances. Without the part `uncalibrated`.

{by_group}
Residuals where nothing is hidden, each in its own standard deviation, before any cause is sought:

{null_scores}
## What is hidden, and what is answered

![Confusion table](images/blind.png)

*A row for what is hidden in a whole rig, a column for what stands first.*

{by_effect}
## Misses

{misses}"""
COMPARED = """## Against earlier code

On the trials of seed {seed}, which were drawn before; `old_c607ca5` is the code before the
present method. What was learnt on these trials went into the code whose figures stand above. Times
are not compared: the load of the machine differed. Nor is `heldout_gap_cut`: the present method
measures it in the significant cells, the one before over all windows.

{table}
"""


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
    named = {*answer['effects'], *answer['parameters']}
    ways = {
        'the workflow failed': answer['verdict'] == 'crashed',
        'reported as indistinguishable from the right one': any(
            right & {n for row in alike for n in row.split('+')} for alike in answer['alike']
        ),
        f'put on another balance: {answer["balance"]}': answer['part'] == 'removed'
        and scores.unknown(answer),
        'another one takes its place': answer['part'] == 'removed'
        and answer['verdict'] in ('effect', 'parameter'),
        'found, but not first': bool(right) and right <= named,
        'judged consistent': bool(right) and answer['verdict'] == 'consistent',
        'one found, not all': bool(right & named),
        'ranked, another fits better': bool(
            right & {name for row in answer['ranking'] for name in row.split('+')}
        ),
        'another takes its place': bool(right),
    }
    return next((way for way, holds in ways.items() if holds), 'fits noise')


def described(answers: list[Answer]) -> str:
    """Return how far descriptions of removed effects cut the gap, and of which they hardly do."""
    removed = [a for a in scores.seen(answers, 'removed') if scores.unknown(a)]
    removed = [a for a in removed if a['cut'] is not None]
    if not removed:
        return ''
    low, middle, high = np.percentile([a['cut'] for a in removed], (25.0, 50.0, 75.0))
    text = (
        'A removed effect that is called `unknown` is described by empirical terms. They cut the '
        f'gap above noise on held-out bags by {percent(middle)} (median of {len(removed)}; '
        f'quartiles {percent(low)} to {percent(high)}).'
    )
    least = [a for a in removed if a['cut'] < LEAST_CUT]
    trials = ', '.join(f'`{a["names"][0]}` ({a["cylinder"][-1]})' for a in least)
    hardly = f' By less than {percent(LEAST_CUT)} in {len(least)}, effect (cylinder): {trials}.'
    return textwrap.fill(text + (hardly if least else ''), 99) + '\n'


def ran_at(answers: list[Answer], revision: str) -> str:
    """Return the revisions at which the answers were given, the one they are kept under first."""
    others = sorted({str(a['revision']) for a in answers} - {revision})
    return ' and '.join([revision, *others])


def as_json(answers: list[Answer], revision: str, seed: int) -> dict[str, Any]:
    """Return the content of ``docs/blind.json``."""
    return {
        **scores.figures(answers),
        'matrix': {'run': len(answers), 'trials': len(drawn(seed))},
        'revision': revision,
        'seed': seed,
        'seconds': median([a['seconds'] for a in answers]) if answers else None,
    }


def write(
    answers: list[Answer],
    docs: Path,
    revision: str,
    seed: int = SEED,
    others: dict[str, list[Answer]] | None = None,
) -> None:
    """
    Write the page, the figures and the picture into a folder.

    :param others: what earlier revisions answered to the trials of an earlier seed
    """
    whole = drawn(seed)
    text = TEXT.format(
        seed=seed,
        revision=revision,
        ran_at=ran_at(answers, revision),
        run=len(answers),
        whole=len(whole),
        folder=FOLDER,
        visible=scores.VISIBLE,
        dim=sum(not scores.shows(a) for a in answers),
        headline=headline(answers),
        described=described(answers),
        comparison=COMPARED.format(seed=EARLIER, table=comparison(others)) if others else '',
        coverage=coverage(answers, whole),
        by_system=by_system(answers),
        by_group=by_group(answers),
        null_scores=null_scores(answers),
        by_effect=by_effect(answers),
        misses=misses(answers),
    )
    draw(answers, docs / PICTURE)
    (docs / 'blind.md').write_text(text)
    data = as_json(answers, revision, seed)
    (docs / 'blind.json').write_text(json.dumps(data, indent=2) + '\n')


def write_kept(source: Path, docs: Path, revision: str, seed: int = SEED) -> list[Answer]:
    """
    Write the page of a revision from the answers that are kept; return these.

    :param source: folder with the answers of each revision
    """
    answers = kept(source / f'{revision}.jsonl', drawn(seed))
    earlier = drawn(EARLIER)
    files = sorted(source.glob('*.jsonl'))
    others = {path.stem: rows for path in files if (rows := kept(path, earlier))}
    write(answers, docs, revision, seed, others)
    return answers
