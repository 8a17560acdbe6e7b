"""One laboratory for all tests: the default reading, measured once."""

from collections.abc import Callable
from pathlib import Path

import pytest

from pneu_rig_ros.claims import experiments
from pneu_rig_ros.claims.experiments import Laboratory, Reading
from pneu_rig_ros.claims.findings import Row
from pneu_rig_ros.claims.statements import STATEMENTS, measure
from pneu_rig_ros.cli import main


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


Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(
    laboratory: Laboratory, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> Run:
    """Return what runs `pneu-rig claims` here, in the one laboratory if the reading is its own."""
    own = experiments.Laboratory

    def found(reading: Reading) -> Laboratory:
        return laboratory if reading == laboratory.reading else own(reading)

    monkeypatch.setattr(experiments, 'Laboratory', found)

    def run_claims(*arguments: object) -> tuple[int, str, str]:
        code = main(['claims', *(str(argument) for argument in arguments)])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run_claims
