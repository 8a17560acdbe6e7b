"""What is answered for what is hidden, counted and drawn."""

from pathlib import Path

import matplotlib as mpl
import numpy as np

from pneu_rig_ros.scenarios.hidden import EFFECTS

from . import scores
from .answers import Answer

OTHERS = ('a parameter', 'consistent', 'unknown', 'crashed')
"""Answers that name no effect."""


def said(answer: Answer) -> str:
    """Return the column of the confusion table that an answer belongs to."""
    if answer['verdict'] == 'effect':
        return str(scores.first_name(answer))
    return 'a parameter' if answer['verdict'] == 'parameter' else str(answer['verdict'])


def confusion(answers: list[Answer]) -> tuple[list[str], np.ndarray]:
    """Return the columns and the counts, a row for each effect and one for nothing hidden."""
    columns = [*EFFECTS, *OTHERS]
    rows = {name: i for i, name in enumerate((*EFFECTS, 'nothing'))}
    counts = np.zeros((len(rows), len(columns)), dtype=int)
    for a in [*scores.seen(answers, 'single'), *scores.seen(answers, 'none')]:
        row = rows[a['names'][0] if a['names'] else 'nothing']
        counts[row, columns.index(said(a))] += 1
    return columns, counts


def draw(answers: list[Answer], path: Path) -> None:
    """Draw the confusion table."""
    mpl.use('Agg')
    import matplotlib.pyplot as plt

    columns, counts = confusion(answers)
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    figure, axes = plt.subplots(figsize=(9.5, 8.4), layout='constrained')
    axes.imshow(shares, cmap='Blues', vmin=0.0, vmax=1.0, aspect='auto')
    for row, column in zip(*np.nonzero(counts), strict=True):
        dark = shares[row, column] > 0.5
        axes.text(
            column,
            row,
            counts[row, column],
            ha='center',
            va='center',
            fontsize=7,
            color='white' if dark else 'black',
        )
    names = [name.replace('_', ' ') for name in columns]
    axes.set_xticks(range(len(columns)), names, rotation=90, fontsize=8)
    rows = [*names[: len(EFFECTS)], 'nothing']
    axes.set_yticks(range(len(rows)), rows, fontsize=8)
    axes.axvline(len(EFFECTS) - 0.5, color='grey', linewidth=0.8)
    axes.axhline(len(EFFECTS) - 0.5, color='grey', linewidth=0.8)
    axes.set_xlabel('answered')
    axes.set_ylabel('hidden')
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)
