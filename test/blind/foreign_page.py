"""``docs/blind_foreign.md`` and ``docs/blind_foreign.json``, written from the answers alone."""

import json
from pathlib import Path

from . import scores
from .answers import FOLDER, Answer, kept
from .foreign import FORMS, KNOWN, UNKNOWN
from .foreign_scores import by_form, figures, headline
from .foreign_trials import FOREIGN_PARTS, drawn_foreign
from .page_tables import percent, table

NAME = 'blind_foreign'
TEXT = """# Blind trials in a foreign world

Written by `make blind ARGS='--part foreign_world'`. The second plant of these trials has laws that
differ from those of the library: {forms} forms, {known} of a mechanism that the library has under
another formula, {unknown} of none that it has (`test/blind/foreign.py`). The other parts add weak
nuisances, conditions that are not as stated, and two or three forms at a time.

The trials were drawn afresh from seed {seed}, strengths, shapes and cylinders, and run once at git
{revision}, in an order in which any first part is a fair sample, for as long as there was time.
The list of forms is the one from which the trials for building were drawn, with other seeds. Every
answer is a line of `docs/{folder}/{revision}_foreign.jsonl`. Recordings, sensors and what is
counted are as in [Blind trials](blind.md).

{headline}
## How much was run

{coverage}
## Form by form

{by_form}
## Answers

{answers}"""


def coverage(answers: list[Answer], seed: int) -> str:
    """Return how many trials of each part were run, and in how many something shows."""
    rows = []
    for part in FOREIGN_PARTS:
        own = [a for a in answers if a['part'] == part]
        shown = sum(scores.shows(a) for a in own)
        rows.append((f'`{part}`', len(own), len(drawn_foreign(seed, (part,))), shown))
    return table(('part', 'run', 'drawn', 'visible'), rows)


def said(answers: list[Answer]) -> str:
    """Return a row for each answer."""
    rows = sorted(
        (
            f'`{a["key"]}`', f'{a["visibility"]:.0f}', a['verdict'],
            a['error'] or ', '.join([*a['effects'], *a['parameters'], *a['conditions']]) or '-',
            ', '.join(a['ranking'][:3]) or '-', percent(a['cut']), f'{a["seconds"]:.0f}',
        )
        for a in answers
    )  # fmt: skip
    head = 'trial', 'visibility', 'verdict', 'named', 'ranked', 'cut', 's'
    return table(head, rows)


def write_kept(source: Path, docs: Path, revision: str, seed: int) -> None:
    """
    Write the page of a revision from the answers that are kept.

    :param source: folder with the answers of each revision
    """
    answers = kept(source / f'{revision}_foreign.jsonl', drawn_foreign(seed))
    text = TEXT.format(
        forms=len(FORMS), known=len(KNOWN), unknown=len(UNKNOWN), seed=seed, revision=revision,
        folder=FOLDER, headline=headline(answers), coverage=coverage(answers, seed),
        by_form=by_form(answers), answers=said(answers),
    )  # fmt: skip
    (docs / f'{NAME}.md').write_text(text)
    data = {**figures(answers), 'revision': revision, 'seed': seed}
    (docs / f'{NAME}.json').write_text(json.dumps(data, indent=2) + '\n')
