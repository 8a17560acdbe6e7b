"""What the README and the pages promise is so: topics, figures, links, pictures."""

import json
import re
from pathlib import Path

import pytest

from benchmarks.__main__ import PAGE, RESULTS, table
from pneu_rig_ros.model import effects
from pneu_rig_ros.records.topics import TOPICS

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / 'README.md').read_text()


def test_topics_named_in_the_readme_exist() -> None:
    for name in ('u', 'joint_states', 'chamber_1/pressure', 'chamber_2/pressure', 'friction'):
        assert f'`{name}`' in README
        assert name in TOPICS


def test_figures_are_those_of_the_last_bench() -> None:
    results = json.loads(RESULTS.read_text())
    assert table(results) in PAGE.read_text()
    text, live = ' '.join(README.split()), results['live']
    assert f'{results["realtime_factor"]:.0f} simulated seconds per second' in text
    assert f'{results["speedup_vs_best_peer"]:.1f} times the best of' in text
    assert f'{live["rate_hz"]:.3f} Hz over DDS' in text
    assert f'{live["missed"]} ticks missed, {live["lost"]} samples lost' in text


def test_statements_that_hold_are_counted() -> None:
    rows = (ROOT / 'docs' / 'claims.md').read_text().splitlines()
    holds = [row.split('|')[3].strip() for row in rows if re.match(r'\| \d+ \|', row)]
    assert f'{holds.count("yes")} of {len(holds)} statements of the paper are reproduced' in README


def test_readme_is_short() -> None:
    assert len(README) < 6450


def test_badges_are_true() -> None:
    low, high = re.findall(r'python-3\.(\d+)_to_3\.(\d+)', README)[0]
    assert f"python_requires='>=3.{low}'" in (ROOT / 'setup.py').read_text()
    # make takes Python from where there are wheels of ROS 2
    assert f'Python 3.{low} to 3.{high} found' in (ROOT / 'Makefile').read_text()
    assert '<license>Apache-2.0</license>' in (ROOT / 'package.xml').read_text()
    assert 'Apache License' in (ROOT / 'LICENSE').read_text()
    assert re.search('^ros.*jazzy', (ROOT / 'requirements.txt').read_text(), re.M | re.I)
    assert '\nstrict = true' in (ROOT / 'pyproject.toml').read_text()


def test_map_names_every_layer_and_what_it_names_exists() -> None:
    page = (ROOT / 'docs' / 'architecture.md').read_text()
    for layer in (ROOT / 'pneu_rig_ros').glob('[!_]*'):
        assert f'`{layer.stem}`' in page or layer.stem == 'errors', layer.stem
    for path in re.findall(r'`((?:pneu_rig_ros|test|config|launch|analysis)/[\w/.]*)`', page):
        folder = ROOT / 'pneu_rig_ros' if path.startswith('analysis') else ROOT
        assert re.search(r'NAME|/X$', path) or (folder / path).exists(), path
    for row in re.findall(r'^\| ((?:`\w+`,? ?)+) \| .* \| .* \|', page, re.MULTILINE)[:7]:
        for node in re.findall(r'\w+', row):
            assert (ROOT / 'pneu_rig_ros' / 'nodes' / f'{node}.py').exists(), node


def test_effects_named_in_the_readme_exist() -> None:
    named = [name for name in effects.names() if not effects.load(name).describes]
    assert f'{len(named)} optional physical effects' in README
    for name in re.findall(r'^  (\w+): \{', README, re.MULTILINE):
        assert name in effects.names()


@pytest.mark.parametrize(
    'page', ['README.md', *(f'docs/{p.name}' for p in ROOT.glob('docs/*.md'))]
)
def test_links_lead_somewhere(page: str) -> None:
    path = ROOT / page
    # docs/reference is made when the documentation is built, and its links are tested there
    for target in re.findall(r'\]\((?!http|reference/)([^)#]+)', path.read_text()):
        assert (path.parent / target).exists(), target


@pytest.mark.parametrize('page', sorted(ROOT.glob('docs/*.md')), ids=lambda page: page.name)
def test_links_say_something_without_sphinx(page: Path) -> None:
    text = page.read_text()
    assert '[](' not in text
    if '](reference/' in text:
        assert '`make docs`' in text, 'a page that is there after `make docs` alone'


def test_pictures_stay_small() -> None:
    pictures = list((ROOT / 'docs').rglob('*.png'))
    assert pictures
    for picture in pictures:
        assert picture.stat().st_size < 200_000, picture


def test_functions_named_in_the_equations_page_exist() -> None:
    rows = (ROOT / 'docs' / 'equations.md').read_text()
    named = re.findall(r'`(\w+/\w+\.py): ((?:\w+`?, `?)*\w+)`', rows)
    pairs = [(file, name) for file, names in named for name in re.findall(r'\w+', names)]
    assert len(pairs) > 20
    for file, name in pairs:
        source = (ROOT / 'pneu_rig_ros' / file).read_text()
        assert re.search(rf'^(def|class) {name}\b', source, re.MULTILINE), f'{file}: {name}'
