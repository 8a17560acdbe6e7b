"""The paper's statements as one self-contained HTML page: findings, values, curves."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
import matplotlib
from matplotlib.figure import Figure

from pneu_rig_ros.batch.strokes import END_SHARE
from pneu_rig_ros.claims.captions import stroke_text, summary
from pneu_rig_ros.claims.experiments import CYLINDERS, LONGEST_STROKE, Laboratory
from pneu_rig_ros.claims.findings import Row
from pneu_rig_ros.claims.readings import (
    SPECIFICATIONS,
    open_quantities,
    printed_values_changed,
    short_text,
)
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.description import git_revision
from pneu_rig_ros.report.claims_figures import Picture, pictures

FIGURES_OF = {
    1: ('fig-4',), 2: ('fig-5',), 3: ('fig-6',), 4: ('fig-7',), 5: ('fig-8',), 6: ('fig-9',),
    7: ('fig-10',), 8: ('fig-11', 'fig-12', 'fig-13'), 9: ('fig-3',), 10: (), 11: ('fig-5',),
    12: ('fig-7',), 13: ('fig-8',), 14: ('fig-11', 'fig-12', 'fig-13'),
    15: ('fig-11', 'fig-12', 'fig-13'), 16: (), 17: (),
}  # fmt: skip
"""Number of a statement -> figures that show it."""


class Value(NamedTuple):
    """One quantity of the reading: in the text of the YAML files, for each cylinder."""

    name: str
    meaning: str
    texts: tuple[str, ...]
    printed: bool


class Drawn(NamedTuple):
    """A figure, drawn."""

    picture: Picture
    address: str


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
    :param progress: called with the number of figures drawn
    :raises RigError: when the file cannot be written
    """
    figures = []
    for number, picture in enumerate(pictures(), start=1):
        figures.append(Drawn(picture, data_address(picture.draw(laboratory))))
        progress(number)
    text = _template().render(
        rows=rows,
        shares=shares,
        strokes=[stroke_text(line) for line in summary(laboratory)],
        figures=figures,
        figures_of=FIGURES_OF,
        reading=laboratory.reading,
        values=list(reading_table(laboratory)),
        changed=printed_values_changed(laboratory.reading),
        cylinders=[name.replace('_', ' ') for name in CYLINDERS],
        end_share=END_SHARE,
        longest_stroke=LONGEST_STROKE,
        version=version('pneu_rig_ros'),
        revision=git_revision(),
    )
    try:
        path.write_text(text, encoding='utf-8')
    except OSError as error:
        raise RigError(f'cannot write the page {path}: {error.strerror}') from error
    return path


def reading_table(laboratory: Laboratory) -> Iterator[Value]:
    """Yield what the paper does not print, and what the reading changes of the printed."""
    models = [laboratory.reading.model(name) for name in CYLINDERS]
    changed = [tuple(name.split('.')) for name in printed_values_changed(laboratory.reading)]
    for section, key in dict.fromkeys([*open_quantities(), *changed]):
        specification = SPECIFICATIONS[section][key]
        used = [getattr(getattr(model, section), key) for model in models]
        texts = tuple(short_text(specification, value) for value in used)
        yield Value(key, specification.description, texts, (section, key) in changed)


def data_address(figure: Figure) -> str:
    """Return a figure as a data URI of SVG: sharp at any size, the same at every run."""
    picture = io.BytesIO()
    settings: Any = {'svg.hashsalt': 'pneu_rig_ros', 'svg.fonttype': 'path',
                'path.simplify': True, 'path.simplify_threshold': 0.25}  # fmt: skip
    nothing = dict.fromkeys(('Date', 'Creator', 'Format', 'Type'))
    with matplotlib.rc_context(settings):
        figure.savefig(picture, format='svg', metadata=nothing)
    return 'data:image/svg+xml;base64,' + base64.b64encode(picture.getvalue()).decode()


def _template() -> jinja2.Template:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader('pneu_rig_ros', 'report'),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template('claims_page.html')
