"""Figures of the last runs: ``docs/reliability.json``, and in words ``docs/reliability.md``."""

import json
import re
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parents[1] / 'docs'


def keep(section: str, figures: dict[str, Any], text: str, docs: Path = DOCS) -> None:
    """
    Put one section's figures and text in the place of those of its last run.

    :param section: its key in the JSON file; ``<!-- section -->`` and ``<!-- /section -->`` mark
        its place on the page
    :param figures: anything that JSON holds
    :param text: Markdown
    :raises ValueError: if the page has no such place
    """
    page = docs / 'reliability.md'
    start, end = f'<!-- {section} -->', f'<!-- /{section} -->'
    place = re.compile(f'{re.escape(start)}.*?{re.escape(end)}', re.DOTALL)
    if not place.search(page.read_text()):
        raise ValueError(f'{page}: no place {start} ... {end}')
    written = f'{start}\n{text.strip()}\n{end}'
    store = docs / 'reliability.json'
    kept = json.loads(store.read_text()) if store.exists() else {}
    store.write_text(json.dumps(kept | {section: figures}, indent=2) + '\n')
    page.write_text(place.sub(lambda _: written, page.read_text()))
