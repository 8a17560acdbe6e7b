"""Who may import whom: data flows from the equations to the report, and ROS stands outside."""

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import pytest

PACKAGE = 'pneu_rig_ros'
ROOT = Path(__file__).resolve().parents[1] / PACKAGE
MANIFEST = ElementTree.parse(ROOT.parent / 'package.xml')
ROS = {key.text for key in MANIFEST.iter('exec_depend') if key.text and '-' not in key.text}
SCIENCE = {'numpy', 'numba', 'yaml'}
BAGS = SCIENCE | {'backports', 'lz4', 'mcap', 'rosbags'}
TABLES = BAGS | {'pint', 'pyarrow'}
FIGURES = BAGS | {'scipy', 'matplotlib', 'jinja2'}
TERMINAL = {'click', 'rich'}
WEB = {'aiohttp', 'jinja2'}
CLUSTER = {'dask', 'distributed'}

# room: the rooms of the package it may import from, the outside packages it may import
RULES: dict[str, tuple[set[str], set[str]]] = {
    '__init__': (set(), set()),
    'errors': (set(), set()),
    'executor': (set(), CLUSTER),
    'model': (set(), SCIENCE),
    'batch': ({'model'}, SCIENCE),
    'rig': ({'model'}, SCIENCE),
    'records': ({'model', 'rig'}, TABLES),
    'analysis': ({'model', 'rig', 'records'}, BAGS | {'scipy'}),
    'control': ({'model', 'rig', 'analysis'}, SCIENCE),
    'claims': (
        {'model', 'batch', 'rig', 'records', 'analysis', 'executor'},
        {'numpy', 'scipy', 'yaml'},
    ),
    'sweep': ({'model', 'batch', 'rig', 'analysis', 'executor'}, {'numpy'}),
    'diagnosis': ({'model', 'rig', 'records', 'analysis', 'executor'}, {'numpy', 'scipy'}),
    'web': (set(), WEB),
    'report': (
        {'model', 'batch', 'rig', 'records', 'analysis', 'claims', 'diagnosis', 'web'},
        FIGURES,
    ),
    'simulate': ({'model', 'rig', 'records', 'analysis'}, BAGS | {'scipy'}),
    'nodes': (
        {'model', 'rig', 'records', 'analysis', 'control'},
        BAGS | {'scipy'} | ROS,
    ),
    'demo': ({'model', 'rig', 'records', 'analysis', 'report', 'nodes'}, FIGURES | TERMINAL),
    'scenarios': (
        {'model', 'rig', 'records', 'analysis', 'report', 'demo'},
        {'numpy', 'yaml'},
    ),
    'cli': (
        {
            'model',
            'rig',
            'records',
            'analysis',
            'claims',
            'diagnosis',
            'report',
            'web',
            'simulate',
            'executor',
            'sweep',
            'nodes',
            'demo',
            'scenarios',
        },
        FIGURES | TERMINAL,
    ),
}


def imports(tree: ast.AST) -> Iterator[str]:
    """Yield the full name of everything imported anywhere in a module."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f'line {node.lineno}: relative import; name it in full'
            assert node.module is not None
            if node.module == PACKAGE:
                yield from (f'{PACKAGE}.{name.name}' for name in node.names)
            else:
                yield node.module


def room(module: Path) -> str:
    """Return the part of the package that a file belongs to."""
    return module.relative_to(ROOT).parts[0].removesuffix('.py')


@pytest.mark.parametrize(
    'module', sorted(ROOT.rglob('*.py')), ids=lambda module: str(module.relative_to(ROOT))
)
def test_imports_only_what_its_room_may(module: Path) -> None:
    here = room(module)
    rooms, outside = RULES[here]
    allowed = {PACKAGE, *(f'{PACKAGE}.{name}' for name in rooms | {here, 'errors'})}
    for name in imports(ast.parse(module.read_text())):
        first = name.split('.')[0]
        if first == PACKAGE:
            assert '.'.join(name.split('.')[:2]) in allowed, f'{here} takes {name}'
        elif first not in sys.stdlib_module_names:
            assert first in outside, f'{here} takes {name}'


@pytest.mark.parametrize(
    'module',
    [
        'cli',
        'simulate',
        'records',
        'analysis',
        'claims',
        'diagnosis.workflow',
        'report',
        'web.server',
    ],
)
def test_works_without_ros(module: str) -> None:
    code = (
        f'import sys, {PACKAGE}.{module}; '
        "print(*(name for name in sys.modules if name.split('.')[0] == 'rclpy'))"
    )
    run = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert run.stdout.split() == []
