"""Bad input in short: every reader is tried, and what once went wrong stays mended."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import hypothesis
import pytest
from long import seeds
from long.attempt import Tally, attempt, inputs, is_one_line
from long.readers import READERS

from pneu_rig_ros.errors import LONGEST_LINE, RigError
from pneu_rig_ros.records import read_recording

CORPUS = Path(__file__).parent / 'corpus'
EXAMPLES = {'bag': 20, 'sealed bag': 30, 'foreign bag': 30, 'reading': 6}
"""Reader -> how many examples are tried of those that take long."""


@pytest.mark.parametrize('name', READERS)
def test_bad_input_is_refused_in_one_line_and_good_input_is_read(
    name: str, tmp_path: Path
) -> None:
    tally = Tally()
    for data in READERS[name].seeds():
        attempt(name, data, tmp_path, tally)
    assert tally.refused == 0

    @hypothesis.settings(max_examples=EXAMPLES.get(name, 60), database=None, derandomize=True)
    @hypothesis.given(inputs(name))
    def try_one(data: bytes) -> None:
        attempt(name, data, tmp_path, tally)

    try_one()
    assert tally.refused > 0


@pytest.mark.parametrize('file', sorted(CORPUS.iterdir()), ids=lambda file: file.name)
def test_inputs_that_once_went_wrong(file: Path, tmp_path: Path) -> None:
    """Their names begin with the reader's."""
    attempt(file.name.split('.')[0].replace('_', ' '), file.read_bytes(), tmp_path, Tally())


@pytest.mark.parametrize('which', ['chunk', 'index', 'metadata'])
def test_one_changed_bit_is_found(
    which: str, tmp_path: Path, changed_bag: Callable[[str], Path]
) -> None:
    with pytest.raises(RigError, match=r'[cC]hecksum'):
        read_recording(changed_bag(which))


@pytest.fixture
def changed_bag(tmp_path: Path) -> Callable[[str], Path]:
    """Return a bag in which one bit of a sample, of the index or of metadata.yaml is changed."""

    def make(which: str) -> Path:
        file, text = bytearray(seeds.protected_bag()), bytearray(seeds.bag_metadata())
        if which == 'metadata':
            text[text.index(b'bore: 0.') + 9] ^= 1
        elif which == 'index':
            file[file.rindex(b'/chamber_1/pressure') + 9] ^= 3
        else:
            file[file.index(b'piston', file.index(b'</robot>')) + 30] ^= 1
        bag = tmp_path / 'stroke'
        bag.mkdir()
        (bag / 'stroke.mcap').write_bytes(file)
        (bag / 'metadata.yaml').write_bytes(text)
        return bag

    return make


def test_bag_without_checksums_is_read_and_told(tmp_path: Path) -> None:
    (tmp_path / 'bag.mcap').write_bytes(seeds.unprotected_bag())
    assert not read_recording(tmp_path).protected


def test_errors_are_one_printable_line() -> None:
    error = RigError('a\nname \x1b[2J \u202e' + 'x' * 10_000 + ' allowed: b')
    assert is_one_line(str(error))
    assert str(error).startswith('a name \\x1b[2J \\u202e')
    assert str(error).endswith('allowed: b')
    assert len(str(error)) <= LONGEST_LINE + 5
