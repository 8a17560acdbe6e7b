"""The table of statements in docs/claims.md is what `pneu-rig claims --markdown` prints."""

import re
from collections.abc import Sequence
from pathlib import Path

import pytest

from pneu_rig_ros.claims.findings import Row, markdown

from .conftest import Run

PAGE = Path(__file__).resolve().parents[2] / 'docs' / 'claims.md'
NUMBER = r'-?\d+(?:\.\d+)?'


def test_page_quotes_the_table(rows: Sequence[Row]) -> None:
    quoted = PAGE.read_text().split('claims --markdown --no-neighbours -->\n')[1]
    quoted = quoted.split('\n<!-- end of claims -->')[0]
    table = markdown(rows)
    assert re.sub(NUMBER, '#', quoted) == re.sub(NUMBER, '#', table)
    # another processor may round differently
    measured, now = (
        [float(value) for value in re.findall(NUMBER, text)] for text in (quoted, table)
    )
    assert measured == pytest.approx(now, rel=0.02, abs=0.011)


def test_command_prints_the_table(run: Run, rows: Sequence[Row]) -> None:
    assert run('--no-neighbours', '--markdown') == (0, markdown(rows) + '\n', '')
