"""
Phrases that are not the language of the field do not come back.

Searched are the text of the package, its documentation, messages, comments and configuration;
commands and identifiers as well, as they are read too. The tests themselves are not.
"""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
BANNED = {
    r'(?<!\.)(?<!tight to )\b(told|tells?)\b(?! ((them|it|both|two) )?apart)': 'reported; prints',
    r'\bin noises\b': 'in standard deviations',
    r'\b(left|leaves?|leave) out\b': 'held-out, excluded, omitted, skipped',
    r'\bsays? nothing\b': 'is ignored, has no information',
    r'\bin the end\b': 'finally',
    r'\bshall\b': 'is to, must, reference',
    r'(?<!there )\bis no [a-z]+[;:,.]': 'is not a ...',
    r'\bto be found\b': 'not found',
    r'\b(broke|breaks?) down\b': 'failed: non-finite state',
    r'\bcomes? to\b(?!\s+(?:# )?rest| a rest| a stop| an end)': 'is, yields; one summary row each',
    r'\bfound out\b': 'detected, determined, estimated',
    r'\bas a whole or\b': 'atomically',
    r'\b(whoever|nobody)\b': 'any client, any user; not known',
    r'\bless (measured|modelled)\b': 'minus measured',
    r'\bas plain data\b': 'as a JSON-compatible dict',
    r'\bfor (a person|people)\b': 'human-readable, display',
    r'\bgives? way\b': 'does not start',
    r'\banew\b': 'again, restarted',
    r'\bin (their|its) pace\b': 'at recorded speed',
}
"""Pattern -> words to use in its place."""
PLACES = (
    'Makefile',
    '*.md',
    '*.rst',
    'docs/*.md',
    'docs/*.py',
    'config/**/*.yaml',
    'launch/*.py',
    'benchmarks/*.py',
    'examples/**/*.py',
    'pneu_rig_ros/**/*.py',
    'pneu_rig_ros/**/*.html',
)
FILES = sorted(path for place in PLACES for path in ROOT.glob(place))


def hits(text: str) -> list[str]:
    """Return each banned phrase in a text, with its line and what to write in its place."""
    return [
        f'{text.count(chr(10), 0, found.start()) + 1}: {found[0]!r}, better: {better}'
        for pattern, better in BANNED.items()
        for found in re.finditer(pattern, text, re.IGNORECASE)
    ]


@pytest.mark.parametrize('path', FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_no_banned_phrase(path: Path) -> None:
    assert hits(path.read_text(encoding='utf-8')) == []


def test_phrases_are_found_across_lines_and_case() -> None:
    assert hits('The recorder\nTold so.')[0].startswith('2: ')
    assert hits('It comes to rest. Nothing tells them apart. A held-out run.') == []
