"""The package as pip installs it: away from its source, with nothing but what its wheel holds."""

import os
import re
import subprocess
import sys
import sysconfig
import venv
from collections.abc import Callable, Iterator
from pathlib import Path
from shutil import copytree, ignore_patterns
from zipfile import ZipFile

import pytest
from diagnosis.parts import LEAKING, mapping, system_file, table, vessel_run
from packaging.requirements import Requirement

pytestmark = pytest.mark.live

PACKAGE = 'pneu_rig_ros'
ROOT = Path(__file__).resolve().parents[1]
SOURCE_ONLY = ignore_patterns('.*', '__pycache__', '*.egg-info', 'build', 'install', 'log', 'runs')
# what depends on the environment of the tests, and where ROS 2 is configured
FOREIGN = ('PYTHON', 'LD_LIBRARY_PATH', '_ROS_WHEELS', 'ROS_', 'RMW_', 'AMENT_', 'FAST')
IMPORT_ALL = f"""
import importlib, pkgutil, {PACKAGE} as package
assert package.__file__.startswith(__import__('sys').prefix), package.__file__
for module in pkgutil.walk_packages(package.__path__, '{PACKAGE}.'):
    if not module.name.startswith('{PACKAGE}.nodes') and not module.name.endswith('__main__'):
        importlib.import_module(module.name)
"""
TABLE = ''.join(f'{k * 1e-3},{k * 2e-5},{5e5 + k},{1e5 + k},0.34\n' for k in range(1500))
MAPPING = """
time: {column: t, unit: s}
position: {column: x, unit: m}
pressure_1: {column: p1, unit: Pa}
pressure_2: {column: p2, unit: Pa}
u: {column: u, unit: V}
"""


def run(*command: str | Path, cwd: Path) -> str:
    """Return what a command prints, run in an environment of its own."""
    own = {key: value for key, value in os.environ.items() if not key.startswith(FOREIGN)}
    done = subprocess.run(command, cwd=cwd, env=own, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def build_wheel(folder: Path, *options: str) -> Path:
    """Return the wheel, built from a copy of the source."""
    copytree(ROOT, folder / 'source', ignore=SOURCE_ONLY)
    words = ('pip', 'wheel', '--quiet', '--no-deps', *options, './source')
    run(sys.executable, '-m', *words, cwd=folder)
    return next(folder.glob('*.whl'))


@pytest.fixture(scope='module')
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the wheel of the setuptools that is installed."""
    return build_wheel(tmp_path_factory.mktemp('wheel'), '--no-build-isolation')


def link_dependencies(prefix: Path) -> None:
    """Link into a virtual environment all that is installed beside this package."""
    site = Path(sysconfig.get_path('purelib')).relative_to(sys.prefix)
    for folder in (Path('lib'), Path('share'), site):
        (prefix / folder).mkdir(exist_ok=True)
        for item in Path(sys.prefix, folder).iterdir():
            link = prefix / folder / item.name
            if PACKAGE not in item.name and not link.exists():
                link.symlink_to(item)


@pytest.fixture(scope='module', params=['linked', pytest.param('full', marks=pytest.mark.long)])
def programs(
    request: pytest.FixtureRequest, wheel: Path, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """Return the bin/ of a virtual environment with the wheel and what it depends on."""
    prefix = tmp_path_factory.mktemp('installed')
    venv.create(prefix)
    if request.param == 'linked':
        link_dependencies(prefix)
        what = ['--no-deps', str(wheel)]
    else:
        what = ['--constraint', str(ROOT / 'requirements.txt'), f'{wheel}[ros,scale,tables]']
    run(sys.executable, '-m', 'pip', '--python', prefix, 'install', '--quiet', *what, cwd=prefix)
    return prefix / 'bin'


def files(folder: str) -> Iterator[Path]:
    """Yield the files of a folder of the source."""
    for path in (ROOT / folder).rglob('*'):
        if path.is_file() and path.suffix != '.pyc':
            yield path.relative_to(ROOT)


def test_wheel_holds_every_file(wheel: Path) -> None:
    with ZipFile(wheel) as archive:
        names = archive.namelist()
    share = f'{wheel.name.partition("-py3")[0]}.data/data/share/{PACKAGE}'
    wanted = {str(path) for path in files(PACKAGE)}
    wanted |= {f'{share}/{path}' for folder in ('config', 'launch') for path in files(folder)}
    assert wanted <= set(names)


def test_build_has_no_upper_limit_of_setuptools() -> None:
    text = (ROOT / 'pyproject.toml').read_text()
    (required,) = re.findall(r"^requires = \['([^']*)'\]", text, re.MULTILINE)
    assert Requirement(required).name == 'setuptools'
    assert Requirement(required).specifier.contains('9999')


@pytest.mark.long
def test_newest_setuptools_builds_the_same_wheel(wheel: Path, tmp_path: Path) -> None:
    with ZipFile(wheel) as one, ZipFile(build_wheel(tmp_path)) as other:
        names = [
            {name for name in each.namelist() if 'dist-info' not in name} for each in (one, other)
        ]
    assert names[0] == names[1]


@pytest.fixture
def pneu_rig(programs: Path, tmp_path: Path) -> Callable[[str], str]:
    """Return what runs `pneu-rig` in an empty directory."""
    return lambda words: run(programs / 'pneu-rig', *words.split(), cwd=tmp_path)


def test_every_module_without_ros_is_imported(programs: Path, tmp_path: Path) -> None:
    run(programs / 'python', '-c', IMPORT_ALL, cwd=tmp_path)


def test_demonstration_runs_live(pneu_rig: Callable[[str], str], tmp_path: Path) -> None:
    pneu_rig('demo --duration 1 --out bag')
    assert (tmp_path / 'bag/stroke.png').is_file()


@pytest.mark.long
def test_leak_of_a_chamber_is_diagnosed(pneu_rig: Callable[[str], str], tmp_path: Path) -> None:
    for seed, fill in enumerate((6e5, 5e5)):
        pressure = vessel_run(seed, fill, warm=0.0, leak=5e-9, conductance=0.0)
        table(tmp_path / f'run_{seed}.csv', 0.1, pressure)
    system, known = system_file(tmp_path, LEAKING), mapping(tmp_path / 'map.yaml', 'pressure_1')
    words = f'--model {system} --map {known} --workers 1 --out answer'
    out = pneu_rig(f'diagnose run_0.csv --verify run_1.csv {words}')
    assert 'lacks chamber_leak' in out
    names = {path.name for path in (tmp_path / 'answer').iterdir()}
    assert names == {'diagnosis.json', 'improved.yaml', 'report.html'}


def test_table_is_imported(pneu_rig: Callable[[str], str], tmp_path: Path) -> None:
    (tmp_path / 'daq.csv').write_text('t,x,p1,p2,u\n' + TABLE)
    (tmp_path / 'map.yaml').write_text(MAPPING)
    pneu_rig('import daq.csv --map map.yaml --cylinder cylinder_2 --out bag')
    assert (tmp_path / 'bag/metadata.yaml').is_file()
