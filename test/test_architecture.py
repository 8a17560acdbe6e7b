"""Who may import whom: data flows from the equations to the report, and ROS stands outside."""

import ast
import subprocess
import sys
from collections.abc import Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from importlib.metadata import packages_distributions
from pathlib import Path
from xml.etree import ElementTree

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PACKAGE = 'pneu_rig_ros'
ROOT = Path(__file__).resolve().parents[1] / PACKAGE
MANIFEST = ElementTree.parse(ROOT.parent / 'package.xml')
ROS, ROS_OF_TESTS = (
    {key.text for key in MANIFEST.iter(kind) if key.text and '-' not in key.text}
    for kind in ('exec_depend', 'test_depend')
)
STANDARD = sys.stdlib_module_names | {'compression'}  # which Python has from 3.14 on
SCIENCE = {'numpy', 'numba', 'yaml'}
BAGS = SCIENCE | {'backports', 'lz4', 'mcap', 'rosbags'}
TABLES = BAGS | {'pint', 'pyarrow'}
FIGURES = BAGS | {'scipy', 'matplotlib', 'jinja2'}
TERMINAL = {'click', 'rich'}
WEB = {'aiohttp', 'jinja2'}
CLUSTER = {'distributed'}

# layer: the layers of the package it may import from, the outside packages it may import
RULES: dict[str, tuple[set[str], set[str]]] = {
    '__init__': (set(), set()),
    'arrays': (set(), {'numpy'}),
    'errors': (set(), set()),
    'executor': (set(), CLUSTER),
    'model': (set(), SCIENCE),
    'batch': ({'model'}, SCIENCE),
    'rig': ({'model'}, SCIENCE),
    'records': ({'model', 'rig'}, TABLES),
    'analysis': ({'model', 'rig', 'records'}, BAGS),
    'control': ({'model', 'rig', 'analysis'}, SCIENCE),
    'claims': (
        {'model', 'batch', 'rig', 'records', 'analysis', 'executor'},
        {'numpy', 'yaml'},
    ),
    'sweep': ({'model', 'batch', 'rig', 'analysis', 'executor'}, {'numpy'}),
    'diagnosis': ({'model', 'rig', 'records', 'analysis', 'executor'}, {'numpy', 'scipy'}),
    'web': (set(), WEB),
    'report': (
        {'model', 'batch', 'rig', 'records', 'analysis', 'claims', 'diagnosis', 'web'},
        FIGURES,
    ),
    'simulate': ({'model', 'rig', 'records', 'analysis'}, BAGS),
    'nodes': (
        {'model', 'rig', 'records', 'analysis', 'control'},
        BAGS | ROS,
    ),
    'demo': ({'model', 'rig', 'records', 'nodes'}, BAGS),
    'scenarios': (
        {'model', 'rig', 'records', 'analysis', 'executor', 'diagnosis', 'report', 'demo'},
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

# folders of the diagnosis: each may import from itself and from those before it
DIAGNOSIS = ('measured', 'residuals', 'inputs', 'causes', 'search', 'answer')


def imports(tree: ast.AST) -> Iterator[str]:
    """Yield the full name of everything imported anywhere in a module."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            module = '.' * node.level + (node.module or '')
            yield from (f'{module}.{name.name}' for name in node.names)


class WithoutTypeChecking(ast.NodeTransformer):
    """Removes what is imported for annotations only."""

    def visit_If(self, node: ast.If) -> ast.AST | list[ast.stmt]:
        if ast.unparse(node.test) in ('TYPE_CHECKING', 'typing.TYPE_CHECKING'):
            return node.orelse
        return self.generic_visit(node)


def import_graph(modules: Mapping[str, str]) -> dict[str, set[str]]:
    """Return module -> modules that it imports when it runs, also within functions."""
    graph = {}
    for module, source in modules.items():
        tree = WithoutTypeChecking().visit(ast.parse(source))
        names = {name if name in modules else name.rpartition('.')[0] for name in imports(tree)}
        graph[module] = names & modules.keys()
    return graph


def import_cycle(graph: Mapping[str, set[str]]) -> list[str]:
    """Return modules of which each is imported by the next one, the first by itself; or none."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def layer_of(module: Path) -> str:
    """Return the part of the package that a file belongs to."""
    return module.relative_to(ROOT).parts[0].removesuffix('.py')


@pytest.mark.parametrize(
    'module', sorted(ROOT.rglob('*.py')), ids=lambda module: str(module.relative_to(ROOT))
)
def test_imports_only_what_its_layer_may(module: Path) -> None:
    here = layer_of(module)
    layers, outside = RULES[here]
    allowed = {PACKAGE, *(f'{PACKAGE}.{name}' for name in layers | {here, 'arrays', 'errors'})}
    for name in imports(ast.parse(module.read_text())):
        first = name.split('.')[0]
        if first == PACKAGE:
            assert '.'.join(name.split('.')[:2]) in allowed, f'{here} imports {name}'
        elif first not in STANDARD:
            assert first in outside, f'{here} imports {name}'


@pytest.mark.parametrize('folder', DIAGNOSIS)
def test_folders_of_the_diagnosis_import_from_those_before_them(folder: str) -> None:
    allowed = DIAGNOSIS[: DIAGNOSIS.index(folder) + 1]
    modules = list((ROOT / 'diagnosis' / folder).glob('*.py'))
    assert len(modules) > 1
    for module in modules:
        for name in imports(ast.parse(module.read_text())):
            if name.startswith(f'{PACKAGE}.diagnosis'):
                assert name.split('.')[2] in allowed, f'{module.name} imports {name}'


def declared(*extras: str) -> set[str]:
    """Return what setup.py requires, as pip spells it."""
    setup = ast.parse((ROOT.parent / 'setup.py').read_text()).body[-1]
    assert isinstance(setup, ast.Expr)
    assert isinstance(setup.value, ast.Call)
    values = {argument.arg: argument.value for argument in setup.value.keywords}
    optional = ast.literal_eval(values['extras_require'])
    required = ast.literal_eval(values['install_requires'])
    required += [text for extra in extras for text in optional[extra]]
    return {canonicalize_name(Requirement(text).name) for text in required}


@pytest.mark.parametrize(
    ('folder', 'extras'),
    [
        (PACKAGE, ('tables', 'scale')),
        ('examples', ()),
        ('benchmarks', ('tables', 'scale', 'test', 'bench')),
        ('test', ('tables', 'scale', 'test')),
    ],
)
def test_every_package_imported_is_declared(folder: str, extras: tuple[str, ...]) -> None:
    names = {
        name.split('.')[0]
        for module in (ROOT.parent / folder).rglob('*.py')
        for name in imports(ast.parse(module.read_text()))
    }
    own = {path.stem for path in (*ROOT.parent.glob('*'), *ROOT.parent.glob('test/*'))} | {''}
    known, providers = declared(*extras), packages_distributions()
    for name in sorted(
        names - STANDARD - ROS - own - (ROS_OF_TESTS if folder == 'test' else set())
    ):
        candidates = {canonicalize_name(provider) for provider in providers.get(name, [name])}
        assert candidates & known, f'{folder} imports {name}, setup.py lacks it'


def test_works_without_ros() -> None:
    modules = ('cli', 'simulate', 'records', 'analysis', 'claims', 'diagnosis.workflow', 'report')
    names = ', '.join(f'{PACKAGE}.{module}' for module in (*modules, 'web.server'))
    code = f"import sys, {names}; print('rclpy' in sys.modules)"
    run = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ['False']


def test_no_import_cycles() -> None:
    modules = {
        '.'.join(path.relative_to(ROOT.parent).with_suffix('').parts).removesuffix(
            '.__init__'
        ): path.read_text()
        for path in ROOT.rglob('*.py')
    }
    graph = import_graph(modules)
    assert import_cycle(graph) == []


def test_finds_cycles_within_functions_but_not_for_types() -> None:
    lazy = {'a.b': 'def f(): from a import c', 'a.c': 'import a.b'}
    assert set(import_cycle(import_graph(lazy))) == {'a.b', 'a.c'}
    typed = {'a.b': 'if TYPE_CHECKING:\n    from a.c import C', 'a.c': 'from a.b import B'}
    assert import_cycle(import_graph(typed)) == []
