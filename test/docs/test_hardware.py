"""The page on real test benches: its commands are those that `make hardware` repeats."""

import re
import shlex
from pathlib import Path

import pytest

from benchmarks.hardware import PAGE, ROOT, Bench, benches, update

TEXT = PAGE.read_text(encoding='utf-8')
BENCHES = benches()


def test_every_diagnosis_of_the_page_is_repeated() -> None:
    assert len(BENCHES) == TEXT.count('\npneu-rig diagnose') > 4
    assert len({bench.name for bench in BENCHES}) == len(BENCHES)


@pytest.mark.parametrize('bench', BENCHES, ids=lambda bench: bench.name)
def test_shipped_files_are_there_and_the_output_is_on_the_page(bench: Bench) -> None:
    words = shlex.split(bench.line)
    for word in words:
        if word.startswith('config/'):
            assert (ROOT / word).is_file(), word
    (output,) = re.findall(rf'<!-- {bench.name}: \w+ -->\n(.*?)<!-- end -->', TEXT, re.DOTALL)
    assert 'remaining excess' in output
    assert not re.search(r'^(took|data|model|report) ', output, re.MULTILINE)


def test_output_of_a_bench_replaces_its_own_only(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    copy = tmp_path / 'page.md'
    copy.write_text(TEXT, encoding='utf-8')
    monkeypatch.setattr('benchmarks.hardware.PAGE', copy)
    update(BENCHES[0].name, 'Heat is missing.\n\ngap    9\ntook   1 s\n')
    changed = copy.read_text(encoding='utf-8')
    assert '```text\nHeat is missing.\n\ngap    9\n```' in changed
    assert [bench.line for bench in benches()] == [bench.line for bench in BENCHES]
    begin = TEXT.index('\n## A seal over pressure')
    assert changed[changed.index('\n## A seal over pressure') :] == TEXT[begin:]
