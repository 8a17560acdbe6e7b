"""
Every fenced command and program of the README, CONTRIBUTING and the pages works.

Quick commands run in a directory that has a short recording under each name that the pages use.
Of commands that are slow, do not end or need other programs, the words are checked against the
package: options, files, nodes, parameters, arguments of launch files, topics. `make test-long`
runs the slow ones.
"""

import importlib
import json
import os
import re
import shlex
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import click
import numpy as np
import pytest
import yaml
from ros.bystander import DOMAIN

from pneu_rig_ros.cli import command, main
from pneu_rig_ros.nodes.embedding import embedded
from pneu_rig_ros.nodes.rig_node import RigNode
from pneu_rig_ros.records.topics import TOPICS
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.rig.configuration import OVERRIDES
from pneu_rig_ros.simulate import simulate

ROOT = Path(__file__).resolve().parents[2]
PAGES = (ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', *sorted((ROOT / 'docs').glob('*.md')))
FENCE = re.compile(r'^```(\{?\w*\}?)[^\n]*\n(.*?)^```$', re.MULTILINE | re.DOTALL)
BAGS = ('a', 'b', 'c', 'first', 'monday', 'tuesday', 'measured', 'BAG')
SLOW = ('claims', 'demo', 'diagnose', 'gap', 'live', 'sweep')
"""Subcommands that take long or do not end."""
RUN_WHEN_LONG = ('diagnose', 'sweep')
"""Those of them that no other test runs as they are."""
OTHERS = {'cat', 'colcon', 'cp', 'dask', 'do', 'done', 'eval', 'export', 'for', 'rviz2', 'source'}
"""Other programs, and words of the shell."""
PACKAGE = ['ros2', 'run', 'pneu_rig_ros']


class Block(NamedTuple):
    """A fenced block."""

    page: str
    language: str
    text: str

    def commands(self) -> list[str]:
        """Return the commands of a shell block, without comments and here-documents."""
        text = re.sub(r" *>> \S+ <<'(\w+)'\n.*?^\1$", '', self.text, flags=re.M | re.S)
        if data := re.match(r'D=(\S+)\n', text):
            text = text[data.end() :].replace('$D', str(ROOT / data[1]))
        lines = text.replace('\\\n', ' ').splitlines()
        lines = [re.sub(r'(\s+#.*| &)$', '', line).strip() for line in lines]
        return [part for line in lines for part in line.split(' && ') if part]


BLOCKS = [Block(path.name, *found) for path in PAGES for found in FENCE.findall(path.read_text())]
COMMANDS = [
    (block.page, line)
    for block in BLOCKS
    if not block.language
    for line in block.commands()
    if not re.search(r'\[--|error:|^(r|E) = ', line)  # synopses, messages, formulas
]


def yaml_of(page: str, word: str) -> str:
    """Return the YAML block of a page that has a word."""
    return next(b.text for b in BLOCKS if b[:2] == (page, 'yaml') and word in b.text)


def words_of(*first: str) -> list[list[str]]:
    """Return the different commands that begin so, as words."""
    lines = dict.fromkeys(line for _, line in COMMANDS)
    every = [shlex.split(line) for line in lines]
    return [words for words in every if words[: len(first)] == list(first)]


def subcommands(*names: str) -> list[list[str]]:
    """Return the arguments of `pneu-rig` in all commands with these subcommands."""
    return [words[1:] for words in words_of('pneu-rig') if words[1] in names]


@pytest.fixture(scope='module')
def recordings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a directory with what the pages take for granted."""
    folder = tmp_path_factory.mktemp('recordings')
    rig = load_configuration('cylinder_2')
    for seed, name in enumerate(BAGS, start=rig.seed):  # a copy is refused by diagnose
        simulate(replace(rig, seed=seed), 0.34, 3.0, folder / 'runs' / name)
    (folder / 'answer').mkdir()
    for name in ('my_rig.yaml', 'my_cylinder.yaml', 'improved.yaml', 'answer/improved.yaml'):
        (folder / name).write_text(rig.to_yaml())
    (folder / 'map.yaml').write_text(yaml_of('measured_data.md', 't [ms]'))
    (folder / 'cond.yaml').write_text(yaml_of('measured_data.md', 'load_mass'))
    milliseconds = np.arange(3000.0)
    constants = [np.full(milliseconds.size, value) for value in (2.0, 30.0, 0.34)]
    position = 60.0 + 20.0 * np.sin(2e-3 * milliseconds)
    table = np.column_stack([milliseconds, *constants, position])
    heads = 't [ms],p cap,p rod,command,x'
    np.savetxt(folder / 'daq.csv', table, '%.6g', ',', header=heads, comments='')
    return folder


@pytest.fixture
def workspace(recordings: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the working directory: an own view of the recordings, in which files are created."""
    shutil.copytree(recordings, tmp_path, copy_function=os.link, dirs_exist_ok=True)
    (tmp_path / 'config').symlink_to(ROOT / 'config')
    monkeypatch.chdir(tmp_path)
    return tmp_path


def make_room(arguments: list[str]) -> None:
    """Remove what a command is to create, if it is there."""
    if '--out' in arguments:
        path = Path(arguments[arguments.index('--out') + 1])
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)


def need_data(arguments: list[str]) -> None:
    """Skip where the measured data are not."""
    for word in arguments:
        if word.startswith(str(ROOT)) and not Path(word).exists():
            pytest.skip(f'no {word}')


def test_every_command_belongs_to_a_test() -> None:
    ours = {'pneu-rig', 'make', 'python', '.venv/bin/python'}
    for page, line in COMMANDS:
        program = shlex.split(line)[0]
        assert program in ours | OTHERS or line.startswith('ros2 '), f'{page}: {line}'
    assert len(COMMANDS) > 60


@pytest.mark.parametrize(
    'arguments', subcommands(*(set(command.commands) - set(SLOW))), ids=' '.join
)
def test_quick_command_runs(
    arguments: list[str], workspace: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make_room(arguments)
    shorter = ['--duration', '1'] if arguments[0] == 'simulate' else []
    assert main([*arguments, *shorter]) == 0, capsys.readouterr().err


@pytest.mark.parametrize('arguments', subcommands(*SLOW), ids=' '.join)
def test_options_of_slow_command_exist(arguments: list[str]) -> None:
    name, *rest = arguments
    command.commands[name].make_context(name, rest, parent=click.Context(command))


@pytest.mark.long
@pytest.mark.parametrize('arguments', subcommands(*RUN_WHEN_LONG), ids=' '.join)
def test_slow_command_runs(
    arguments: list[str], workspace: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if '--scheduler' in arguments:
        pytest.skip('needs a cluster')
    need_data(arguments)
    make_room(arguments)
    assert main(arguments) == 0, capsys.readouterr().err


@pytest.mark.long
def test_tutorial_finds_the_leak(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = (ROOT / 'docs' / 'tutorial.md').read_text()
    rig = (ROOT / 'config' / 'cylinder_1.yaml').read_text()
    leak = re.search(r"<<'END'\n(.*?)END", text, re.DOTALL)
    assert leak
    Path('my_rig.yaml').write_text(rig + leak[1])
    lines = [shlex.split(line) for page, line in COMMANDS if page == 'tutorial.md']
    for words in (words for words in lines if 'my_rig.yaml' in words or 'diagnose' in words):
        if words[0] == 'pneu-rig':
            assert main(words[1:]) == 0
    answer = json.loads(Path('answer/diagnosis.json').read_text())
    assert [effect['name'] for effect in answer['effects']] == ['chamber_leak']
    low, high = answer['effects'][0]['parameters']['area_1']['interval']
    assert low < 1e-8 < high


@pytest.mark.parametrize(
    'block', [block for block in BLOCKS if block.language == 'python'], ids=lambda b: b.page
)
def test_program_runs(block: Block, workspace: Path) -> None:
    if 'diagnose(' in block.text:
        pytest.skip('takes a minute; test/diagnosis calls the same')
    exec(compile(block.text, block.page, 'exec'), {})


@pytest.mark.parametrize(
    'block', [block for block in BLOCKS if block.language == 'yaml'], ids=lambda b: b.page
)
def test_yaml_is_valid(block: Block) -> None:
    assert isinstance(yaml.safe_load(block.text), dict)


@pytest.mark.parametrize('words', words_of('make'), ids=' '.join)
def test_make_target_exists(words: list[str]) -> None:
    subprocess.run([*words, '--dry-run'], cwd=ROOT, stdout=subprocess.DEVNULL, check=True)


@pytest.mark.parametrize(
    'words', [*words_of('python'), *words_of('.venv/bin/python')], ids=' '.join
)
def test_python_file_exists(words: list[str]) -> None:
    modules = [words[k + 1].replace('.', '/') + '.py' for k, w in enumerate(words) if w == '-m']
    files = [word for word in words if word.endswith('.py')]
    names = [*(name for name in modules if name != 'pytest.py'), *files]
    assert names
    for name in names:
        assert (ROOT / name).exists(), name


@pytest.mark.parametrize('words', words_of('cp'), ids=' '.join)
def test_file_to_be_copied_exists(words: list[str]) -> None:
    assert (ROOT / words[1].removeprefix('PATH_TO_THE_PACKAGE/')).exists()


@pytest.mark.parametrize('words', words_of('ros2', 'launch', 'pneu_rig_ros'), ids=' '.join)
def test_launch_arguments_exist(words: list[str]) -> None:
    files = (words[3], 'rig.launch.py')  # the others include that of the rig
    source = ''.join((ROOT / 'launch' / name).read_text() for name in files)
    for word in words[4:]:
        assert f"'{word.split(':=')[0]}'" in source, word


def node_class(name: str) -> type[RigNode]:
    """Return the class of a node."""
    module = importlib.import_module(f'pneu_rig_ros.nodes.{name}')
    (kind,) = (
        kind
        for kind in vars(module).values()
        if isinstance(kind, type)
        and issubclass(kind, RigNode)
        and kind.__module__ == module.__name__
    )
    return kind


@pytest.mark.parametrize('words', words_of(*PACKAGE), ids=' '.join)
def test_parameters_of_node_exist(words: list[str]) -> None:
    kind = node_class(words[3])
    declared = {p.name for p in (*kind.PARAMETERS, *kind.SHARED)}
    declared |= {'use_sim_time', *(OVERRIDES if words[3] == 'plant' else ())}
    assert {word.split(':=')[0] for word in words[4:] if ':=' in word} <= declared


@pytest.mark.parametrize('words', words_of('ros2', 'topic', 'pub'), ids=' '.join)
def test_published_topic_exists(words: list[str]) -> None:
    name, kind, message = words[-3:]
    content = yaml.safe_load(message)
    if name.split('/')[1] in yaml.safe_load((ROOT / 'config' / 'ros2_control.yaml').read_text()):
        assert isinstance(content, dict)  # a topic of a stock controller
        return
    assert TOPICS[name.strip('/')].type == kind
    assert set(content) == {'data'}


def typed(text: str) -> object:
    """Return a value of a ROS argument: a number or flag, else the text."""
    try:
        return json.loads(text)
    except ValueError:
        return text


@pytest.mark.live
@pytest.mark.parametrize('words', words_of(*PACKAGE), ids=' '.join)
def test_node_starts_with_the_parameters(
    words: list[str], workspace: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In this process; `test/ros` starts the executables."""
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    monkeypatch.setenv('ROS_DOMAIN_ID', str(DOMAIN))
    given = [word.split(':=') for word in words[4:] if ':=' in word]
    overrides = {name: typed(value) for name, value in given}
    shutil.rmtree(workspace / 'runs' / 'monday')  # the recorder creates it
    kind = node_class(words[3])
    with embedded(lambda context: kind(context, overrides), 'page') as (node, _):
        for name, value in overrides.items():
            assert node.get_parameter(name).value == value
