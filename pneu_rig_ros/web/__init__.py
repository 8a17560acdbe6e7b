"""Self-contained pages for a browser: templates with styles, scripts and data in them."""

import json
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

import jinja2

ASSETS = files('pneu_rig_ros') / 'web' / 'assets'
"""Charts are drawn by uPlot 1.6.32 (MIT licence in the same folder)."""


def render(template: str, data: Mapping[str, Any], **variables: Any) -> str:
    """
    Return a page.

    :param template: file name in the folder of assets
    :param data: plain data that the scripts find in the element `data`; NaN is not allowed
    """
    # In a script element only '<' can end the data.
    text = json.dumps(data, allow_nan=False, separators=(',', ':')).replace('<', '\\u003c')
    return _TEMPLATES.get_template(template).render(data=text, asset=_text, **variables)


def _text(name: str) -> str:
    """Return the text of an asset."""
    return (ASSETS / name).read_text(encoding='utf-8')


def environment(loader: jinja2.BaseLoader) -> jinja2.Environment:
    """Return templates that escape what is put into them, and refuse what is not given."""
    return jinja2.Environment(
        loader=loader,
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


_TEMPLATES = environment(jinja2.FunctionLoader(_text))
