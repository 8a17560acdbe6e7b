"""The page holds every statement and figure, needs nothing else, and trusts no name."""

import re
import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest

from pneu_rig_ros.claims.experiments import Laboratory, Reading
from pneu_rig_ros.claims.findings import Finding, Row
from pneu_rig_ros.claims.statements import STATEMENTS
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.report import claims_page
from pneu_rig_ros.report.claims_figures import Picture, pictures
from pneu_rig_ros.report.claims_page import FIGURES_OF, data_address, write_page

VOID = {'meta', 'img'}
CHROMIUM = shutil.which('chromium') or shutil.which('chromium-browser')
SHARES = {statement.number: 0.96 for statement in STATEMENTS}
HOSTILE = '<script>alert("&amp;")</script>'


class Reader(HTMLParser):
    """Checks that every tag is closed in order and collects what a page holds."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = ''
        self.feed(page)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data

    def all(self, attribute: str) -> list[str]:
        return [a[attribute] or '' for _, a in self.tags if attribute in a]


@pytest.fixture(scope='module')
def path(
    rows: list[Row], laboratory: Laboratory, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    return write_page(tmp_path_factory.mktemp('page') / 'page.html', rows, laboratory, SHARES)


@pytest.fixture(scope='module')
def page(path: Path) -> Reader:
    return Reader(path.read_text(encoding='utf-8'))


def test_every_statement_and_finding_is_there(page: Reader, rows: list[Row]) -> None:
    assert page.text.count('96 %') == len(rows)
    verdicts = re.findall(r'holds|does not', page.text[page.text.index('Verdict') :])
    assert verdicts[: len(rows)] == ['holds' if row.holds else 'does not' for row in rows]
    for row in rows:
        assert f'statement-{row.statement.number}' in page.all('id')
        assert row.statement.text in page.text
        for finding in row.findings:
            assert finding.says.replace('cylinder_', 'cylinder ') in page.text
            assert finding.measured in page.text


def test_every_figure_is_there(page: Reader) -> None:
    keys = [picture.key for picture in pictures()]
    assert sorted(keys) == sorted(f'fig-{number}' for number in range(3, 14))
    assert [key for key in page.all('id') if key.startswith('fig-')] == keys
    assert {tag for tag, a in page.tags if 'src' in a} == {'img'}
    assert len(page.all('src')) == len(keys)
    assert all(address.startswith('data:image/svg+xml;base64,') for address in page.all('src'))
    assert {key for keys in FIGURES_OF.values() for key in keys} == set(keys)


def test_links_lead_somewhere_inside(page: Reader) -> None:
    assert page.all('href')
    assert {link.removeprefix('#') for link in page.all('href')} <= set(page.all('id'))


def test_needs_nothing_from_outside(path: Path) -> None:
    text = path.read_text(encoding='utf-8')
    assert not re.search(r'https?:|//\w|url\(|@import|<script|<link', text.replace('data:', ''))
    assert path.stat().st_size < 5_000_000


def test_same_strokes_same_figure(laboratory: Laboratory) -> None:
    draw = next(iter(pictures())).draw
    assert data_address(draw(laboratory)) == data_address(draw(laboratory))


@pytest.fixture
def one_figure(monkeypatch: pytest.MonkeyPatch) -> Picture:
    """Leave one figure on the page, with a name that is not to be trusted."""
    first = next(iter(pictures()))._replace(title=HOSTILE, caption=HOSTILE)

    def only() -> Iterator[Picture]:
        yield first

    monkeypatch.setattr(claims_page, 'pictures', only)
    return first


def test_hostile_names_are_text(
    rows: list[Row], laboratory: Laboratory, one_figure: Picture, tmp_path: Path
) -> None:
    finding = Finding(HOSTILE, HOSTILE, -1.0)
    row = Row(replace(rows[0].statement, text=HOSTILE), (finding,))
    hostile = Laboratory(Reading(HOSTILE))
    hostile.perform_all = laboratory.perform_all  # type: ignore[method-assign]
    text = write_page(tmp_path / 'page.html', [row], hostile, {}).read_text()
    page = Reader(text)
    assert 'script' not in {tag for tag, _ in page.tags}
    # reading in title, tally and values; statement twice; finding twice; figure twice
    assert page.text.count(HOSTILE) == 9
    assert one_figure.title in page.all('alt')


def test_changed_table_2_is_told(
    rows: list[Row], laboratory: Laboratory, one_figure: Picture, tmp_path: Path
) -> None:
    common = {'friction': {'dwell_coefficient': 0.5}, 'operation': {'rest_time': 60.0}}
    changed = Laboratory(Reading('moved', common))
    changed.perform_all = laboratory.perform_all  # type: ignore[method-assign]
    page = Reader(write_page(tmp_path / 'page.html', rows, changed, {}).read_text())
    assert 'changes values that the paper prints: friction.dwell_coefficient' in page.text
    assert '0.5 s^-alpha' in page.text
    assert '60 s' in page.text


def test_unwritable_page_is_told(
    rows: list[Row], laboratory: Laboratory, one_figure: Picture, tmp_path: Path
) -> None:
    with pytest.raises(RigError, match=r'cannot write the page .*: No such file'):
        write_page(tmp_path / 'nowhere' / 'page.html', rows, laboratory, {})


@pytest.mark.skipif(not CHROMIUM, reason='chromium is not installed; the page is not opened')
def test_browser_shows_the_figures(path: Path, tmp_path: Path) -> None:
    assert CHROMIUM
    text = path.read_text(encoding='utf-8')
    # the page itself runs no script; a copy that may says how wide each figure came out
    probe = (
        '<script>onload = () => document.title = '
        '[...document.images].map(i => i.naturalWidth).join(" ")</script>'
    )
    copy = tmp_path / 'probe.html'
    copy.write_text(re.sub(r'<meta http-equiv=[^>]*>', probe, text, count=1), encoding='utf-8')
    options = [
        '--headless', '--no-sandbox', '--disable-gpu', '--no-first-run',
        '--disable-background-networking', '--disable-component-update', '--disable-sync',
        f'--user-data-dir={tmp_path / "profile"}', '--dump-dom',
    ]  # fmt: skip
    shown = subprocess.run(
        [CHROMIUM, *options, copy.as_uri()], capture_output=True, text=True, check=True, timeout=60
    )
    title = re.search('<title>([0-9 ]*)</title>', shown.stdout)
    assert title, shown.stdout[:500]
    widths = [int(width) for width in title[1].split()]
    assert len(widths) == len(list(pictures()))
    assert min(widths) > 500
