"""Sphinx settings of the pages; `make docs` builds them into build/docs."""

import re
import sys
from importlib.metadata import version as installed
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import reference_pages  # noqa: E402  (beside this file)

project = 'pneu_rig_ros'
author = 'pneu_rig_ros maintainers'
copyright = author
release = version = installed('pneu_rig_ros')

extensions = ['myst_parser']
myst_heading_anchors = 4
exclude_patterns = ['images']
nitpicky = True
suppress_warnings = [
    'misc.highlighting_failure',  # a YAML block with "..." in it
]

html_theme = 'furo'
html_title = f'pneu_rig_ros {release}'
html_copy_source = False
html_show_sphinx = False
html_theme_options = {'navigation_with_keys': True}

# What code says is not written down twice: these pages are made of it at each build.
reference_pages.write(HERE / 'reference')


def adapt(app: object, page: str, source: list[str]) -> None:
    """Show links to source folders, which have no page, as their text."""
    source[0] = re.sub(
        r'\[([^]]+)\]\((\.\./[^)#]+)\)',
        lambda link: f'`{link[1]}`' if (HERE / link[2]).is_dir() else link[0],
        source[0],
    )


def setup(app: object) -> None:
    """Connect the above with Sphinx."""
    app.connect('source-read', adapt)
