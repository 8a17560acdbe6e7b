"""The launch files: what they start exists, with the parameters that they give."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FILES = sorted((ROOT / 'launch').glob('*.launch.py'))
EXECUTABLES = {path.stem for path in (ROOT / 'pneu_rig_ros' / 'nodes').glob('*.py')}
OURS = {path.name for path in FILES}


def described(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


def texts(tree: ast.AST) -> set[str]:
    return {
        n.value for n in ast.walk(tree) if isinstance(n, ast.Constant) and type(n.value) is str
    }


def test_all_are_there() -> None:
    names = {path.name.split('.')[0] for path in FILES}
    assert names == {
        'rig',
        'closed_loop',
        'lifecycle',
        'shadow',
        'replay',
        'ros2_control',
    }


@pytest.mark.parametrize('path', FILES, ids=lambda path: path.name)
def test_executables_and_included_files_exist(path: Path) -> None:
    for call in ast.walk(described(path)):
        if not isinstance(call, ast.Call):
            continue
        given = {k.arg: k.value for k in call.keywords}
        executable = given.get('executable')
        if isinstance(executable, ast.Constant) and executable.value != 'robot_state_publisher':
            assert executable.value in EXECUTABLES
        if getattr(call.func, 'id', '') == 'rig_node':
            assert ast.literal_eval(call.args[0]) in EXECUTABLES
        if getattr(call.func, 'id', '') == 'node' and ast.unparse(call.args[0]) == 'PACKAGE':
            assert ast.literal_eval(call.args[1]) in EXECUTABLES
    assert {text for text in texts(described(path)) if text.endswith('.launch.py')} <= OURS


@pytest.mark.parametrize('path', FILES, ids=lambda path: path.name)
def test_every_argument_is_used(path: Path) -> None:
    tree = described(path)
    arguments = next(
        ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign) and getattr(node.targets[0], 'id', '') == 'ARGUMENTS'
    )
    for name, (_, description) in arguments.items():
        assert len(description) > 10
        uses = ast.unparse(tree).count(f"'{name}'") + ast.unparse(tree).count(f'{name}=')
        assert uses > 1, f'{name} is declared but not used'


@pytest.mark.parametrize('path', FILES, ids=lambda path: path.name)
def test_a_full_ros_2_reads_them(path: Path) -> None:
    sources = pytest.importorskip('launch.launch_description_sources', reason='no ROS 2 launch')
    text = sources.PythonLaunchDescriptionSource(str(path))
    description = text.try_get_launch_description_without_context()
    assert description is not None
    assert description.get_launch_arguments()


@pytest.mark.parametrize('name', ['ended', 'ended_unless_killed'])
def test_an_end_ends_all_but_says_nothing_after_ctrl_c(name: str) -> None:
    """An action Shutdown logs that a process was required, even if all are ending already."""
    pytest.importorskip('launch_ros', reason='no ROS 2 launch')
    from launch import LaunchContext
    from launch.events.process import ProcessExited

    from pneu_rig_ros.nodes import launching

    def event(code: int) -> ProcessExited:
        return ProcessExited(
            action=None, name='plant', cmd=[], cwd=None, env=None, pid=1, returncode=code
        )

    ended = getattr(launching, name)
    context = LaunchContext()
    assert len(ended(event(0), context)) == 1
    with pytest.raises(RuntimeError, match='plant has ended with exit code 2'):
        ended(event(2), context)
    context._set_is_shutdown(True)
    assert ended(event(0), context) == ended(event(2), context) == []


def test_a_killed_node_that_is_restarted_ends_nothing() -> None:
    pytest.importorskip('launch_ros', reason='no ROS 2 launch')
    from launch import LaunchContext
    from launch.events.process import ProcessExited

    from pneu_rig_ros.nodes.launching import ended_unless_killed

    event = ProcessExited(
        action=None, name='plant', cmd=[], cwd=None, env=None, pid=1, returncode=-9
    )
    assert ended_unless_killed(event, LaunchContext()) == []
