"""The paper's statements as one self-contained HTML page: findings, values, curves."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from pneu_rig_ros.batch import END_SHARE
from pneu_rig_ros.claims.captions import stroke_texts
from pneu_rig_ros.claims.experiments import CYLINDERS, LONGEST_STROKE, Laboratory
from pneu_rig_ros.claims.findings import Row
from pneu_rig_ros.claims.readings import (
    SPECIFICATIONS,
    open_quantities,
    printed_values_changed,
    short_text,
)
from pneu_rig_ros.records.whole_files import atomic_write
from pneu_rig_ros.report.claims_figures import SHOWS, drawings
from pneu_rig_ros.report.figure import plain_name
from pneu_rig_ros.report.page import draw_all, render


class Value(NamedTuple):
    """One quantity of the reading: as text for each cylinder; whether a printed value changed."""

    name: str
    meaning: str
    texts: tuple[str, ...]
    printed: bool


def write_page(
    path: Path,
    rows: Sequence[Row],
    laboratory: Laboratory,
    shares: Mapping[int, float],
    progress: Callable[[int], None] = lambda _: None,
) -> Path:
    """
    Write the page.

    :param rows: all statements, measured in the laboratory
    :param laboratory: has carried out the experiments
    :param shares: number of a statement -> share of the neighbours under which it holds [-]
    :param progress: callback(number of figures drawn)
    :raises RigError: when the file cannot be written
    """
    text = render(
        'claims_page.html',
        rows=rows,
        shares=shares,
        strokes=stroke_texts(laboratory),
        pictures=draw_all(drawings(laboratory), progress),
        shows=SHOWS,
        reading=laboratory.reading,
        values=reading_table(laboratory),
        changed=printed_values_changed(laboratory.reading),
        cylinders=[plain_name(name) for name in CYLINDERS],
        end_share=END_SHARE,
        longest_stroke=LONGEST_STROKE,
    )
    return atomic_write(path, text)


def reading_table(laboratory: Laboratory) -> Iterator[Value]:
    """Yield what the paper does not print, and what the reading changes of the printed."""
    models = [laboratory.reading.model(name) for name in CYLINDERS]
    changed = printed_values_changed(laboratory.reading)
    for name in dict.fromkeys([*open_quantities(), *changed]):
        section, key = name.split('.')
        specification = SPECIFICATIONS[section][key]
        used = [getattr(getattr(model, section), key) for model in models]
        texts = tuple(short_text(specification, value) for value in used)
        yield Value(key, specification.description, texts, name in changed)
