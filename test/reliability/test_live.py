"""Soak and faults in a short form; the demonstrations that take their full time are programs."""

import os
from collections.abc import Iterator

import pytest

from reliability import soak
from reliability.faults.command import FAULTS, meet, text
from reliability.faults.finding import Finding, Stage
from reliability.live_rig import own_domain

pytestmark = pytest.mark.live

MINUTES = 0.2

BUSIEST = 4.0
"""Programs that wait for each processor, above which none gets the half that the plant takes."""


@pytest.fixture(autouse=True, scope='module')
def _apart() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        for name in ('ROS_AUTOMATIC_DISCOVERY_RANGE', 'ROS_DOMAIN_ID'):
            patch.setenv(name, '')  # restored at the end
        own_domain()
        yield


@pytest.fixture(autouse=True)
def _not_too_busy() -> None:
    waiting = os.getloadavg()[0] / (os.cpu_count() or 1)
    if waiting > BUSIEST:
        pytest.skip(f'{waiting:.0f} programs wait for each processor: too busy for 862 Hz')


@pytest.fixture(scope='module')
def stage(_apart: None) -> Iterator[Stage]:
    """Return a rig that the faults share, in the order of their table."""
    with Stage() as made:
        yield made


def test_live_tests_share_one_worker(request: pytest.FixtureRequest) -> None:
    if 'PYTEST_XDIST_WORKER' in os.environ:
        assert request.node.nodeid.endswith('@live')


def test_soak_loses_nothing_and_reads_its_bag_all_the_while() -> None:
    result = soak.run(MINUTES)
    assert result.samples > 60.0 * MINUTES * 862
    assert not any(result.lost.values())
    assert abs(result.drift_ms) < soak.DRIFT_LIMIT
    assert result.unreadable == []
    assert min(result.looks[reader] for reader in ('pneu-rig', 'mcap', 'rosbags')) >= 1
    assert '| lost' not in soak.text(result)


@pytest.mark.parametrize('name', FAULTS)
def test_what_has_to_happen_happens(name: str, stage: Stage) -> None:
    finding = meet(name, stage)
    if not isinstance(finding, Finding):
        pytest.skip(finding)
    assert finding.held, finding.measured
    assert finding.measured in text({name: finding})
