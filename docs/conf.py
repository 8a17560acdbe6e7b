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
myst_heading_anchors = 3
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
    """Leave out what a page cannot show: entries without a page, links to source folders."""
    lines = source[0].splitlines(keepends=True)
    globs = (line for line in lines if re.fullmatch(r'[a-z_]+\*\n', line))
    absent = {line for line in globs if not any(HERE.glob(f'{line.strip()}.md'))}
    text = ''.join(line for line in lines if line not in absent)
    source[0] = re.sub(
        r'\[([^]]+)\]\((\.\./[^)#]+)\)',
        lambda link: f'`{link[1]}`' if (HERE / link[2]).is_dir() else link[0],
        text,
    )


def setup(app: object) -> None:
    """Connect the above with Sphinx."""
    app.connect('source-read', adapt)
