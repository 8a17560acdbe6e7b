"""The package as a ROS 2 installation has it: built by colcon, run from ``lib/pneu_rig_ros``."""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from importlib.metadata import Distribution, distributions, requires
from pathlib import Path

import pytest
import rclpy
from catkin_pkg.package import Package, parse_package
from packaging.requirements import Requirement
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import JointState

from pneu_rig_ros.records.bag import open_bag
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate

from .domain import own_domain

PACKAGE = 'pneu_rig_ros'
ROOT = Path(__file__).resolve().parents[2]
EXECUTABLES = {
    'plant',
    'valve_command',
    'friction_estimator',
    'recorder',
    'rig',
    'excitation',
    'position_controller',
    'joint_command',
    'replay',
    'shadow',
    'pneu-rig',
}
DOMAIN = own_domain()
PATIENCE = 60.0  # s, for a first start, which compiles the plant

# rosdep key -> name on PyPI, where it is not the key without `python3-`
PIP_NAMES = {
    'mcap-ros2-support': 'mcap',
    'python3-rosbags-pip': 'rosbags',
    'python3-yaml': 'pyyaml',
}
# rosdep has no key for these; they come with rosbags
WITH_ROSBAGS = {'backports.zstd', 'lz4'}
# these come with the wheel of rclpy, or not as a wheel at all
NO_WHEEL = {
    'ament_index_python',
    'launch',
    'launch_ros',
    'lifecycle_msgs',
    'rcl_interfaces',
    'rmw_fastrtps_cpp',
    'robot_state_publisher',
    'ros2launch',
}


def environment() -> dict[str, str]:
    """Return this environment without what the ROS wheels exported when this process started."""
    kept = dict(os.environ)
    if kept.pop('_ROS_WHEELS_BOOTSTRAP_COMPLETE', None):
        kept.pop('LD_LIBRARY_PATH', None)
    return kept | {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', 'ROS_DOMAIN_ID': str(DOMAIN)}


@pytest.fixture(
    scope='module',
    params=[(), pytest.param(('--symlink-install',), marks=pytest.mark.long)],
    ids=['copy', 'symlink'],
)
def workspace(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a workspace in which colcon has built the package."""
    folder = tmp_path_factory.mktemp('workspace')
    shutil.copytree(
        ROOT,
        folder / 'src' / PACKAGE,
        ignore=shutil.ignore_patterns('.*', '__pycache__', 'build', 'install', 'log', 'runs'),
    )
    colcon = shutil.which('colcon', path=f'{Path(sys.executable).parent}:{os.environ["PATH"]}')
    assert colcon is not None, 'colcon is not installed'
    build = subprocess.run(
        [colcon, 'build', *request.param],
        cwd=folder,
        env=environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert build.returncode == 0, build.stdout + build.stderr
    return folder


@pytest.fixture(scope='module')
def prefix(workspace: Path) -> Path:
    """Return where the package is installed."""
    return workspace / 'install' / PACKAGE


def sourced(workspace: Path, *command: str | Path) -> subprocess.Popen[str]:
    """Start a command as in a shell that has sourced the workspace."""
    script = 'source "$0/install/local_setup.bash" && exec "$@"'
    return subprocess.Popen(
        ['bash', '-c', script, workspace, *command],
        cwd=workspace,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def test_every_executable_is_where_ros2_run_looks(prefix: Path) -> None:
    found = {path.name for path in (prefix / 'lib' / PACKAGE).iterdir()}
    assert found == EXECUTABLES
    assert all(os.access(prefix / 'lib' / PACKAGE / name, os.X_OK) for name in found)


def test_share_has_what_the_source_has(prefix: Path) -> None:
    assert (prefix / 'share/ament_index/resource_index/packages' / PACKAGE).is_file()
    for pattern in ('package.xml', 'config/**/*.*', 'launch/*.py'):
        names = [path.relative_to(ROOT) for path in ROOT.glob(pattern)]
        assert names, f'no {pattern} in the source'
        for name in names:
            assert (prefix / 'share' / PACKAGE / name).read_text() == (ROOT / name).read_text()


def test_the_built_package_is_the_one_imported(workspace: Path) -> None:
    code = f'import {PACKAGE}; print({PACKAGE}.__file__)'
    output, _ = sourced(workspace, sys.executable, '-c', code).communicate()
    assert Path(output.strip()).is_relative_to(workspace)


def test_command_line_tells_its_usage(workspace: Path, prefix: Path) -> None:
    process = sourced(workspace, prefix / 'lib' / PACKAGE / 'pneu-rig', '--help')
    output, _ = process.communicate()
    assert process.returncode == 0, output
    assert 'Usage' in output


@pytest.fixture
def context(monkeypatch: pytest.MonkeyPatch) -> Iterator[Context]:
    """Return a context in the domain in which the built nodes run."""
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    context = Context()
    rclpy.init(context=context, domain_id=DOMAIN)
    yield context
    rclpy.shutdown(context=context)


def wait_for_sample(context: Context, plant: subprocess.Popen[str]) -> JointState | None:
    """Return the first sample that a plant publishes, None when it ended or was too slow."""
    node = rclpy.create_node('listener', context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    samples: list[JointState] = []
    node.create_subscription(JointState, 'joint_states', samples.append, 10)
    deadline = time.monotonic() + PATIENCE
    while not samples and plant.poll() is None and time.monotonic() < deadline:
        executor.spin_once(timeout_sec=0.5)
    executor.shutdown()
    node.destroy_node()
    return samples[0] if samples else None


@pytest.mark.live
def test_built_plant_publishes_and_stops_on_ctrl_c(
    workspace: Path, prefix: Path, context: Context
) -> None:
    arguments = ['--ros-args', '-p', 'use_sim_time:=true', '-p', 'speed:=1.0']
    plant = sourced(workspace, prefix / 'lib' / PACKAGE / 'plant', *arguments)
    try:
        sample = wait_for_sample(context, plant)
        plant.send_signal(signal.SIGINT)
        output, _ = plant.communicate(timeout=PATIENCE)
    finally:
        plant.kill()
    assert sample is not None, output
    assert list(sample.name) == ['piston']
    assert plant.returncode == 0, output
    assert 'Traceback' not in output


@pytest.mark.live
def test_launch_files_run_and_end_cleanly(workspace: Path) -> None:
    """What `rig_launch.py` demands of them, by launch_testing."""
    pytest.importorskip('launch_testing', reason='no ROS 2 launch')
    pytest.importorskip('launch_ros', reason='no ROS 2 launch')
    test = Path(__file__).with_name('rig_launch.py')
    run = sourced(workspace, sys.executable, '-m', 'launch_testing.launch_test', test)
    output, _ = run.communicate(timeout=10 * PATIENCE)
    assert run.returncode == 0, output
    assert 'Traceback' not in output
    assert output.count('\nOK') == 6, output


LAUNCH = f"""
import sys
from launch import LaunchDescription, LaunchService
from launch.actions import IncludeLaunchDescription
from launch.substitutions import PathJoinSubstitution
from launch_ros.substitutions import FindPackageShare
file, *words = sys.argv[1:]
path = PathJoinSubstitution([FindPackageShare('{PACKAGE}'), 'launch', f'{{file}}.launch.py'])
given = [tuple(word.split(':=')) for word in words]
service = LaunchService()
service.include_launch_description(
    LaunchDescription([IncludeLaunchDescription(path, launch_arguments=given)])
)
sys.exit(service.run())
"""
"""What `ros2 launch pneu_rig_ros FILE ARGUMENTS` does."""


@pytest.mark.live
@pytest.mark.parametrize(
    ('words', 'message'),
    [
        ('rig friction:=nope', 'plant-1 has ended with exit code 2'),
        ('rig load_mass:=heavy', "argument load_mass: 'heavy' is not a number"),
        ('lifecycle cylinder:=nope', 'plant-4 has ended with exit code 2'),
        ('lifecycle output:=/proc/bag', '/recorder cannot be configured'),
        ('shadow model:=nope record:=true', 'shadow-1 has ended with exit code 2'),
        ('replay bag:=nope', 'nope does not exist'),
    ],
)
def test_launch_file_that_fails_ends_all_with_code_1(
    workspace: Path, words: str, message: str
) -> None:
    pytest.importorskip('launch_ros', reason='no ROS 2 launch')
    run = sourced(workspace, sys.executable, '-c', LAUNCH, *words.split())
    output, _ = run.communicate(timeout=PATIENCE)  # also ends when no process holds its pipe
    assert run.returncode == 1, output
    assert message in output  # launch_ros may add a traceback of its own wait for a service


@pytest.mark.live
def test_model_beside_a_bag_ends_with_it_and_is_recorded(workspace: Path) -> None:
    pytest.importorskip('launch_ros', reason='no ROS 2 launch')
    simulate(load_configuration('cylinder_1'), 0.3, 5.0, workspace / 'bag')
    words = (
        f'shadow model:=cylinder_1 bag:={workspace}/bag record:=true output:={workspace}/shadow'
    )
    run = sourced(workspace, sys.executable, '-c', LAUNCH, *words.split())
    output, _ = run.communicate(timeout=PATIENCE)
    assert run.returncode == 0, output
    with open_bag(workspace / 'shadow') as bag:
        counts = {connection.topic: connection.msgcount for connection in bag.connections}
    samples = round(5.0 / 1.16e-3) + 1
    assert counts['/joint_states'] == samples
    assert counts['/predicted/joint_states'] > 0.9 * samples


@pytest.fixture(scope='module')
def manifest() -> Package:
    """Return package.xml, read by the tool that colcon reads it with."""
    return parse_package(ROOT / 'package.xml')


def pip_name(key: str) -> str:
    """Return what pip calls the package of a rosdep key."""
    return PIP_NAMES.get(key, key.removeprefix('python3-'))


def installed(prefix: Path) -> Distribution:
    """Return the metadata that colcon installed or, with symbolic links, has in its build."""
    build = prefix.parents[1] / 'build' / PACKAGE
    places = [str(build), *(str(path) for path in prefix.glob('lib/python*/site-packages'))]
    return next(iter(distributions(name=PACKAGE, path=places)))


def test_manifest_says_what_setup_says(prefix: Path, manifest: Package) -> None:
    metadata = installed(prefix).metadata
    assert metadata['Version'] == manifest.version
    assert metadata['Summary'] == manifest.description
    assert metadata['License'] in manifest.licenses
    assert manifest.get_build_type() == 'ament_python'


def test_manifest_names_every_dependency_of_setup(prefix: Path, manifest: Package) -> None:
    requirements = [Requirement(text) for text in installed(prefix).requires or []]
    plain = {r.name.lower() for r in requirements if 'extra' not in str(r.marker)}
    wheels = {
        r.name.removeprefix('ros-jazzy-').replace('-', '_')
        for r in requirements
        if 'extra' in str(r.marker) and r.marker and r.marker.evaluate({'extra': 'ros'})
    }
    keys = {dependency.name for dependency in manifest.exec_depends} - NO_WHEEL
    assert {Requirement(text).name for text in requires('rosbags') or []} >= WITH_ROSBAGS
    assert {pip_name(key) for key in keys} == (plain - WITH_ROSBAGS) | wheels


def test_every_release_of_ros_2_has_the_same_wheels(prefix: Path) -> None:
    requirements = [Requirement(text) for text in installed(prefix).requires or []]
    jazzy, kilted = (
        {str(r).split(';')[0].replace(release, '') for r in requirements if release in r.name}
        for release in ('jazzy', 'kilted')
    )
    assert jazzy == kilted != set()
