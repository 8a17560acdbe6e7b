"""One laboratory for all tests: the default reading, measured once."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from terminal import Outcome, Terminal

from pneu_rig_ros.claims import experiments, statements
from pneu_rig_ros.claims.experiments import Laboratory, Reading
from pneu_rig_ros.claims.findings import Row, Statement
from pneu_rig_ros.claims.statements import STATEMENTS, measure


@pytest.hookimpl(tryfirst=True)  # before xdist reads the groups
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Give all tests of this folder to one worker, which then measures once."""
    for item in items:
        if item.path.parent == Path(__file__).parent:
            item.add_marker(pytest.mark.xdist_group('claims'))


@pytest.fixture(scope='session')
def laboratory() -> Laboratory:
    return Laboratory()


@pytest.fixture(scope='session')
def rows(laboratory: Laboratory) -> list[Row]:
    return [measure(laboratory, statement) for statement in STATEMENTS]


Run = Callable[..., Outcome]


@pytest.fixture
def run(
    laboratory: Laboratory,
    rows: list[Row],
    terminal: Terminal,
    monkeypatch: pytest.MonkeyPatch,
) -> Run:
    """Return what runs `pneu-rig claims` here, which finds the default reading measured."""
    own = experiments.Laboratory
    measured = {row.statement: row for row in rows}

    def found(reading: Reading) -> Laboratory:
        return laboratory if reading == laboratory.reading else own(reading)

    def row(where: Laboratory, statement: Statement) -> Row:
        return measured[statement] if where is laboratory else measure(where, statement)

    monkeypatch.setattr(experiments, 'Laboratory', found)
    monkeypatch.setattr(statements, 'measure', row)
    return partial(terminal.run, 'claims')
