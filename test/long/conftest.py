"""A live rig in a DDS domain of its own, and a witness beside it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from .live_rig import ProcessRig
    from .witness import Witness


@pytest.fixture(scope='session')
def domain() -> int:
    """Return a DDS domain of this process alone."""
    from ros.domain import own_domain

    return own_domain()


@pytest.fixture
def apart(domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep DDS on this host and in the domain."""
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    monkeypatch.setenv('ROS_DOMAIN_ID', str(domain))


@pytest.fixture
def rig(apart: None, tmp_path: Path) -> Iterator[ProcessRig]:
    """Return a rig of four processes that records to tmp_path / 'bag'."""
    from .live_rig import ProcessRig

    with ProcessRig(tmp_path / 'bag') as processes:
        yield processes


@pytest.fixture
def witness(rig: ProcessRig) -> Iterator[Witness]:
    """Return a witness that has seen the rig at work."""
    from .witness import Witness

    with Witness() as made:
        rig.check()
        made.hears('friction')
        made.listen(1.0)
        yield made
