"""Bad input in short: every reader is tried, and what once went wrong stays mended."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path

import hypothesis
import pytest

from pneu_rig_ros.errors import LONGEST_LINE, RigError
from reliability.fuzz import campaign, damage, seeds
from reliability.fuzz.attempt import Tally, attempt, complaint
from reliability.fuzz.inputs import edited
from reliability.fuzz.readers import READERS

CORPUS = Path(__file__).parent / 'corpus'
SLOW = {'bag': 2, 'sealed bag': 4, 'foreign bag': 6, 'metadata': 20, 'cut bag': 20, 'reading': 6}
"""Reader -> how many examples are tried of those that take long."""


@pytest.mark.parametrize('name', READERS)
def test_bad_input_is_refused_in_one_line_and_good_input_is_read(
    name: str, tmp_path: Path
) -> None:
    reader, tally = READERS[name], Tally()
    for data in reader.seeds():
        attempt(name, data, tmp_path, tally)
    assert tally.accepted == len(reader.seeds())

    @hypothesis.settings(max_examples=SLOW.get(name, 40), database=None, derandomize=True)
    @hypothesis.given(edited(reader.seeds(), reader.tokens))
    def try_it(data: bytes) -> None:
        attempt(name, data, tmp_path, tally)

    try_it()
    assert tally.failures == {}
    assert tally.refused > 0


@pytest.mark.parametrize('file', sorted(CORPUS.iterdir()), ids=lambda file: file.name)
def test_inputs_that_once_went_wrong(file: Path, tmp_path: Path) -> None:
    """Their names begin with the reader's."""
    tally = Tally()
    attempt(file.name.split('.')[0].replace('_', ' '), file.read_bytes(), tmp_path, tally)
    assert tally.failures == {}


@pytest.mark.parametrize(
    ('name', 'stride'),
    [('cut bag', 401), ('sealed bag', 97), ('metadata', 401), ('foreign bag', 997)],
)
def test_damaged_bags_give_no_wrong_number(name: str, stride: int, tmp_path: Path) -> None:
    tally = Tally()
    for data in itertools.islice(damage.all_of(name, stride), 60):
        attempt(name, data, tmp_path, tally)
    assert tally.failures == {}
    assert tally.refused > 10


@pytest.mark.parametrize('which', ['chunk', 'index', 'metadata'])
def test_one_changed_bit_is_found(
    which: str, tmp_path: Path, changed_bag: Callable[[str], Path]
) -> None:
    from pneu_rig_ros.records import read_recording

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
    from pneu_rig_ros.records import read_recording

    (tmp_path / 'bag.mcap').write_bytes(seeds.unprotected_bag())
    assert not read_recording(tmp_path).protected


def test_failures_are_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def read(data: bytes, _: Path) -> None:
        raise {b'a': ValueError('x'), b'b': RigError('one line')}[data]

    monkeypatch.setitem(READERS, 'broken', READERS['cdr']._replace(read=read))
    tally = Tally()
    attempt('broken', b'a', tmp_path, tally)
    attempt('broken', b'b', tmp_path, tally)
    (told,) = tally.failures.values()
    assert told.endswith('ValueError: x')
    assert tally.refused == 1
    assert complaint('two\nlines')
    assert complaint('')


def test_errors_are_one_printable_line() -> None:
    error = RigError('a\nname \x1b[2J \u202e' + 'x' * 10_000 + ' allowed: b')
    assert complaint(str(error)) == ''
    assert str(error).startswith('a name \\x1b[2J \\u202e')
    assert str(error).endswith('allowed: b')
    assert len(str(error)) <= LONGEST_LINE + 5


def test_campaign_runs_every_reader_by_random_or_damage() -> None:
    runs = campaign.plan(600.0)
    assert {run.reader for run in runs} == set(READERS)
    assert sum(run.seconds for run in runs) == pytest.approx(600.0)


def test_campaign_in_short() -> None:
    runs = [campaign.Run('cdr', 'guided', 1.0)]
    tallies = list(campaign.carry_out(runs, 1, lambda _: None))
    readers = campaign.summary(tallies)
    assert readers['cdr']['failures'] == []
    assert readers['cdr']['tried'] > 200
    assert '| cdr |' in campaign.text(readers, 1.0)
