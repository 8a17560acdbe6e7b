"""The page of a part's diagnosis: the verdict, the tables and what was measured and predicted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from pneu_rig_ros.gap.parts.diagnosis import PartDiagnosis
from pneu_rig_ros.report import diagnosis_rows as rows
from pneu_rig_ros.report.claims_page import data_address
from pneu_rig_ros.report.writing import write_whole

MOST_RANKED = 10
SCALES = {'Pa': ('kPa', 1e-3), 'kg/s': ('mg/s', 1e6)}
"""SI unit -> unit for people, units of it in one SI unit."""
STYLE = (
    'body{font:16px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em}'
    'table{border-collapse:collapse}td,th{padding:.2em .8em;text-align:left;'
    'border-bottom:1px solid #ccc}img{max-width:100%}'
)


def write_part_page(path: Path, found: PartDiagnosis, data: Mapping[str, Any]) -> None:
    """Write the page as a whole or not at all."""
    tables = (
        ('Where the given model disagrees', 'signal,regime,RMS,noise,unit,RMS/noise',
         [row[:6] for row in rows.where_rows(data)]),
        ('What may explain it', 'candidate,kind,stage,gap left,',
         rows.ranking_texts(data, MOST_RANKED)),
        ('What was changed and added', 'parameter,was,value,95 % interval,unit',
         rows.added_rows(data)),
        ('RMSE on recordings left out', 'signal,before,after,noise,unit,before/noise,after/noise',
         rows.gap_rows(data)),
    )  # fmt: skip
    body = [f'<h1>{escape(data["sentence"])}</h1>', f'<p>{escape(rows.cut_text(data))}</p>']
    body += [_table(title, head.split(','), cells) for title, head, cells in tables if cells]
    body += ['<h2>Measured less predicted on recordings left out</h2>']
    body += [f'<img alt="measured less predicted" src="{data_address(_figure(found))}">']
    head = f'<meta charset="utf-8"><title>Diagnosis</title><style>{STYLE}</style>'
    write_whole(path, f'<!doctype html><html lang="en"><head>{head}</head><body>'
                f'{"".join(body)}</body></html>\n')  # fmt: skip


def _table(title: str, head: Sequence[str], cells: Sequence[Sequence[str]]) -> str:
    top = ''.join(f'<th>{escape(text)}</th>' for text in head)
    lines = (''.join(f'<td>{escape(text)}</td>' for text in row) for row in cells)
    body = ''.join(f'<tr>{line}</tr>' for line in lines)
    return f'<h2>{escape(title)}</h2><table><tr>{top}</tr>{body}</table>'


def _figure(found: PartDiagnosis) -> Figure:
    """Return measured less predicted, before and after, of each recording left out."""
    held = found.search.held
    before = held.channels(found.part.hypothesis)
    after = held.channels(found.improved.hypothesis)
    names = [one.name for one in before[0]]
    figure = Figure(figsize=(9.0, 2.4 * len(names) * len(before)), layout='constrained')
    axes = figure.subplots(len(names) * len(before), 1, squeeze=False)[:, 0]
    places = iter(axes)
    for recording, old, new in zip(held.recordings, before, after, strict=True):
        for first, second in zip(old, new, strict=True):
            place = next(places)
            unit, scale = SCALES.get(first.unit, (first.unit, 1.0))
            said = np.isfinite(first.gap)
            time = (1.0 + np.flatnonzero(said)) * recording.interval
            for one, label in ((first, 'given'), (second, 'improved')):
                place.plot(time, scale * one.gap[said], lw=0.8, label=label)
            place.set_title(f'{recording.name}: {first.name} measured less predicted', size=10)
            place.set_ylabel(unit)
            place.legend(loc='upper right', fontsize=8)
    axes[-1].set_xlabel('time [s]')
    return figure
