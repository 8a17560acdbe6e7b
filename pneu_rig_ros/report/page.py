"""Self-contained HTML pages: templates with the figures in them."""

import base64
import io
from collections.abc import Callable, Iterable
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
import matplotlib
from matplotlib.figure import Figure

from pneu_rig_ros.records.description import git_revision
from pneu_rig_ros.records.whole_files import atomic_write
from pneu_rig_ros.report.figure import STYLE
from pneu_rig_ros.web import environment

_TEMPLATES = environment(jinja2.PackageLoader('pneu_rig_ros', 'report'))


class Drawing(NamedTuple):
    """
    A figure of a page, to be drawn.

    :param draw: returns the figure, None where there is nothing to be seen
    :param key: what the template knows it by: its part of the page, or the target of links
    """

    title: str
    caption: str
    draw: Callable[[], Figure | None]
    key: str = ''


def write(
    path: Path,
    template: str,
    drawings: Iterable[Drawing],
    progress: Callable[[int], None],
    **content: Any,
) -> Path:
    """
    Write a page.

    :param template: file in the folder of this module, which extends ``page.html``
    :param drawings: the template gets those in which there is something to be seen as
        ``pictures``, with the data URI of each as its ``address``
    :param progress: callback(number of figures drawn)
    :param content: what else the template gets, beside version and revision
    :raises RigError: when the file cannot be written
    """
    pictures = []
    for number, one in enumerate(drawings, start=1):
        if (figure := one.draw()) is not None:
            pictures.append({**one._asdict(), 'address': data_address(figure)})
        progress(number)
    content |= {'version': version('pneu_rig_ros'), 'revision': git_revision()}
    text = _TEMPLATES.get_template(template).render(pictures=pictures, **content)
    return atomic_write(path, text)


def data_address(figure: Figure) -> str:
    """Return a figure as a data URI of SVG: sharp at any size, the same at every run."""
    picture = io.BytesIO()
    settings: Any = {
        **STYLE,
        'svg.hashsalt': 'pneu_rig_ros',
        'svg.fonttype': 'path',
        'path.simplify_threshold': 0.25,
    }
    nothing = dict.fromkeys(('Date', 'Creator', 'Format', 'Type'))
    with matplotlib.rc_context(settings):
        figure.savefig(picture, format='svg', metadata=nothing)
    return 'data:image/svg+xml;base64,' + base64.b64encode(picture.getvalue()).decode()
