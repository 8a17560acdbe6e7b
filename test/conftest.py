"""What all tests share."""

from __future__ import annotations

import faulthandler
import fcntl
import gc
import os
import shutil
import signal
import sys
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import settings
from other_noise import draw_other_noise
from rerun import rerun_commands
from terminal import Terminal
from xdist.scheduler import LoadGroupScheduling

from pneu_rig_ros.model import effects
from pneu_rig_ros.model.along import MOVES
from pneu_rig_ros.model.plant import Plant
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

CHROMIUM = ('chromium', 'chromium-browser', 'google-chrome')

LONGEST_LIVE_TEST = 280.0
"""Time after which a live test is given up [s], a little less than the `timeout` of all."""

COMPUTING = 10
"""Niceness of a worker that runs no live tests, beside one that does."""

# a shell starts what is in its background deaf to Ctrl-C, and what that starts inherits it
signal.signal(signal.SIGINT, signal.default_int_handler)

# the machine may be busy with live nodes; how long an example takes says nothing
settings.register_profile('steady', deadline=None)
settings.load_profile('steady')


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options of the noise, and of how much the long tests try."""
    parser.addoption('--noise', type=int, default=0, help='draw other noise, number (0: none)')
    group = parser.getgroup('long tests')
    group.addoption('--minutes', type=float, help='of the soak (60), of damaged input (10)')
    group.addoption('--rigs', type=int, help='number of random rigs (10 000)')
    group.addoption('--kills', type=int, help='of each node (20)')


def pytest_configure(config: pytest.Config) -> None:
    """Draw other noise if that is asked for."""
    if number := config.getoption('--noise'):
        draw_other_noise(number)


LIVE, SECOND_PLANT, SLOW, REST = range(4)
"""When a test begins."""


@pytest.hookimpl(tryfirst=True)  # before xdist reads the groups
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Run all live tests on one worker, each slow one by itself; give long tests their time."""
    for item in items:
        if item.get_closest_marker('live'):
            item.add_marker(pytest.mark.xdist_group('live'))
        elif item.get_closest_marker('timeout') and not item.get_closest_marker('xdist_group'):
            item.add_marker(pytest.mark.xdist_group('alone'))
        if item.get_closest_marker('long'):
            item.add_marker(pytest.mark.timeout(0))
    items.sort(key=_rank)
    slow = [item for item in items if _rank(item) == SLOW and 'plants' in _fixtures(item)]
    for item in slow[:1]:  # which compiles what others wait for
        items.remove(item)
        items.insert(sum(_rank(each) == LIVE for each in items), item)


def _fixtures(item: pytest.Item) -> Sequence[str]:
    return item.fixturenames if isinstance(item, pytest.Function) else ()


def _rank(item: pytest.Item) -> int:
    """
    Return when a test begins: of those that are not long the slow ones first.

    While the first slow test compiles the plants of the package, those of the second plant
    compile that.
    """
    live, slow, long = (bool(item.get_closest_marker(m)) for m in ('live', 'timeout', 'long'))
    if live:
        return LIVE
    if slow and not long:
        return SLOW
    return SECOND_PLANT if 'blind' in item.path.parts else REST


def pytest_collection_finish() -> None:
    """Let the collections of garbage at live tests pass over what stays to the end anyway."""
    gc.freeze()


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Let the worker of the live tests go before those that only compute."""
    if 'PYTEST_XDIST_WORKER' in os.environ and not item.get_closest_marker('live'):
        os.nice(max(COMPUTING - os.nice(0), 0))  # going back needs privileges


@pytest.fixture(autouse=True)
def _dds_ends(request: pytest.FixtureRequest) -> Iterator[None]:
    """
    Let the participants of a live test end with it, and end its process if it hangs.

    Left to the garbage collector they would end while others begin. Fast DDS may then wait for
    itself forever, see `runner.exit_after`, where no Python code can run.
    """
    markers = {marker.name for marker in request.node.iter_markers()}
    if 'live' not in markers or 'long' in markers:
        yield
        return
    faulthandler.dump_traceback_later(LONGEST_LIVE_TEST, exit=True, file=sys.__stderr__)
    gc.collect()  # fixtures of the test before may still have held one
    yield
    gc.collect()
    faulthandler.cancel_dump_traceback_later()


@pytest.fixture(scope='session')
def one_worker(
    tmp_path_factory: pytest.TempPathFactory,
) -> Callable[[str], AbstractContextManager[None]]:
    """Return a context that one worker at a time enters: what one compiles serves the others."""

    @contextmanager
    def entered(name: str) -> Iterator[None]:
        with (tmp_path_factory.getbasetemp().parent / name).open('w') as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield

    return entered


@pytest.fixture(scope='session')
def plants(one_worker: Callable[[str], AbstractContextManager[None]]) -> None:
    """Let one worker compile the plants of all diagnoses: with no effect, and with all."""
    model = load_configuration('cylinder_1').model
    measured, voltages = np.full((2, 3), 1e5), np.full((1, 2), 2.5)
    with one_worker('plants'):
        for chosen in ({}, effects.nulls()):
            plant = Plant(model, chosen)
            plant.run(voltages, 1e-3)
            plant.along(measured, np.zeros(1), np.full(1, MOVES), voltages, 1e-3)


class Scheduler(LoadGroupScheduling):
    """Keeps files on one worker, so that their fixtures are made once, but for what is alone."""

    def _split_scope(self, nodeid: str) -> str:
        group: str = super()._split_scope(nodeid)
        if group == nodeid:
            return nodeid.partition('::')[0]
        return nodeid if group == 'alone' else group


def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> LoadGroupScheduling:
    """Return how the tests are shared out."""
    return Scheduler(config, log)


@pytest.hookimpl(wrapper=True, tryfirst=True)  # after all else that is written
def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter,
) -> Generator[None, None, None]:
    """End with a command for each failed test that runs it again."""
    yield
    stats = terminalreporter.stats
    commands = rerun_commands([*stats.get('failed', []), *stats.get('error', [])])
    if commands:
        terminalreporter.section(f'{len(commands)} failed; run one again with')
        terminalreporter.write_line('\n'.join(commands))


@pytest.fixture(scope='session')
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return three simulated seconds of cylinder 2; not to be changed."""
    configuration = load_configuration('cylinder_2')
    return simulate(configuration, 0.34, 3.0, tmp_path_factory.mktemp('bags') / 'stroke')


@pytest.fixture
def terminal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Terminal:
    """Return a place to run `pneu-rig` in."""
    monkeypatch.chdir(tmp_path)
    return Terminal(tmp_path, capsys)


@pytest.fixture(scope='module')
def browser() -> Iterator[Browser]:
    """Return a headless Chromium; skip where there is none."""
    api = pytest.importorskip('playwright.sync_api', reason='playwright is not installed')
    path = next(filter(None, map(shutil.which, CHROMIUM)), None)
    if path is None:
        pytest.skip(f'no {", ".join(CHROMIUM)} on the PATH')
    with api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=path, args=['--no-sandbox'])
        yield chromium
        chromium.close()


@pytest.fixture
def open_page(browser: Browser) -> Iterator[Callable[[str], Page]]:
    """Open pages; at the end none may have met an error or asked for what is not its own."""
    context = browser.new_context(viewport={'width': 1440, 'height': 1000})
    context.set_default_timeout(120_000)  # the machine may be busy
    troubles: list[str] = []
    context.on('weberror', lambda trouble: troubles.append(str(trouble.error)))
    context.on('console', lambda message: troubles.append(f'{message.type}: {message.text}'))

    def open_it(address: str) -> Page:
        page = context.new_page()
        own = address.split('/')[2] or address
        page.on('request', lambda asked: own in asked.url or troubles.append(asked.url))
        page.goto(address)
        return page

    yield open_it
    context.close()
    assert troubles == []
