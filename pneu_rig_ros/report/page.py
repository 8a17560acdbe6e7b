"""Self-contained HTML pages: templates with the figures in them."""

import base64
import io
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import jinja2
import matplotlib
from matplotlib.figure import Figure

from pneu_rig_ros.records.atomic_write import atomic_write
from pneu_rig_ros.records.description import git_revision, package_version
from pneu_rig_ros.report.figure import STYLE
from pneu_rig_ros.web import environment

_TEMPLATES = environment(jinja2.PackageLoader('pneu_rig_ros', 'report'))


Draw = Callable[[], Figure | None]
"""Returns a figure, None where there is nothing to be seen."""


def write(
    path: Path,
    template: str,
    figures: Mapping[str, Draw],
    progress: Callable[[int], None],
    **content: Any,
) -> Path:
    """
    Write a page.

    :param template: file in the folder of this module, which extends ``page.html``
    :param figures: name -> function that draws it; the template gets the data URI of each by its
        name as ``pictures``, None where there is nothing to be seen
    :param progress: callback(number of figures drawn)
    :param content: what else the template gets, beside version and revision
    :raises RigError: when the file cannot be written
    """
    pictures = {}
    for number, (name, draw) in enumerate(figures.items(), start=1):
        figure = draw()
        pictures[name] = None if figure is None else data_address(figure)
        progress(number)
    content |= {'version': package_version(), 'revision': git_revision()}
    text = _TEMPLATES.get_template(template).render(pictures=pictures, **content)
    return atomic_write(path, text)


def data_address(figure: Figure) -> str:
    """Return a figure as a data URI of SVG: sharp at any size, the same at every run."""
    picture = io.BytesIO()
    settings: Any = {
        **STYLE,
        'svg.hashsalt': 'pneu_rig_ros',
        'svg.fonttype': 'path',
        'path.simplify_threshold': 0.5,
    }
    nothing = dict.fromkeys(('Date', 'Creator', 'Format', 'Type'))
    with matplotlib.rc_context(settings):
        figure.savefig(picture, format='svg', metadata=nothing)
    return 'data:image/svg+xml;base64,' + base64.b64encode(picture.getvalue()).decode()
