"""The pages build without a warning, and no link or anchor in them is dead; no network."""

import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
import yaml

from pneu_rig_ros.cli import command
from pneu_rig_ros.model import effects
from pneu_rig_ros.model.parameters import SECTIONS
from pneu_rig_ros.model.quantity import specifications
from pneu_rig_ros.records.topics import TOPICS

DOCS = Path(__file__).resolve().parents[2] / 'docs'


class Page(HTMLParser):
    """Links and anchors of a page."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.feed(path.read_text(encoding='utf-8'))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.links += [given[key] or '' for key in ('href', 'src') if key in given]
        self.anchors |= {given['id'] or ''} if 'id' in given else set()


@pytest.fixture(scope='session')
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the pages; any warning is an error."""
    folder = tmp_path_factory.mktemp('site')
    words = [sys.executable, '-m', 'sphinx', '-W', '--keep-going', '-q', '-b', 'html']
    run = subprocess.run(
        [*words, '-d', str(folder / 'trees'), str(DOCS), str(folder / 'html')],
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    return folder / 'html'


def test_no_link_is_dead(site: Path) -> None:
    pages = {path: Page(path) for path in site.rglob('*.html')}
    followed = 0
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            assert target.exists(), f'{path.name}: {link}'
            if parts.fragment and target in pages:
                assert unquote(parts.fragment) in pages[target].anchors, f'{path.name}: {link}'
            followed += 1
    assert followed > 500


def test_pages_load_nothing_from_elsewhere(site: Path) -> None:
    for path in site.rglob('*.html'):
        for tag in ('<script src="http', '<link rel="stylesheet" type="text/css" href="http'):
            assert tag not in path.read_text(encoding='utf-8'), path.name


def test_reference_names_everything(site: Path) -> None:
    pages = {p.stem: p.read_text() for p in (site / 'reference').glob('*.html')}
    nodes = (DOCS.parent / 'config' / 'nodes.yaml').read_text()
    for topic in TOPICS:
        assert f'>{topic}<' in pages['topics']
    for name in effects.names():
        assert f'id="{name.replace("_", "-")}"' in pages['effects']
    for path in (DOCS.parent / 'pneu_rig_ros').rglob('[!_]*.py'):
        assert f'>{path.name}<' in pages['modules']
    for name in command.commands:
        assert f'id="{name}"' in pages['commands']
    for section in SECTIONS.values():
        for key in specifications(section):
            assert f'>{key}<' in pages['configuration']
    for line in nodes.splitlines():
        key = line.strip('# ').split(':')[0]
        if line.startswith(('    ', '    # ')) and key != 'use_sim_time':
            assert f'>{key}<' in pages['nodes'], key


def test_schema_has_every_parameter(site: Path) -> None:
    (path,) = (site / '_downloads').rglob('parameters.yaml')
    schema = yaml.safe_load(path.read_text())
    assert schema['plant']['speed']['validation'] == {'bounds<>': [0.0, 1000.0]}
    assert schema['valve_command']['trigger']['validation'] == {
        'one_of<>': [['command', 'sample']]
    }
    written = yaml.safe_load((DOCS.parent / 'config' / 'nodes.yaml').read_text())
    for name, node in written.items():
        known = schema[name.removeprefix('/**/')]
        for key, value in node['ros__parameters'].items():
            assert key == 'use_sim_time' or known[key]['default_value'] == value, (name, key)


def test_every_symbol_of_the_nomenclature_has_a_key() -> None:
    text = (DOCS / 'nomenclature.md').read_text()
    for section, kind in SECTIONS.items():
        for word in text.split('`'):
            if word.startswith(f'{section}.'):
                assert word.split('.')[1] in kind._fields, word
