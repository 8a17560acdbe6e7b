"""Soak and faults in a short form; the demonstrations that take their full time are programs."""

import pytest

from reliability import soak
from reliability.faults.command import FAULTS, meet, text
from reliability.faults.finding import Finding
from reliability.live_rig import own_domain

pytestmark = pytest.mark.live

MINUTES = 0.2
KILLS = 1


@pytest.fixture(autouse=True)
def _apart(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ('ROS_AUTOMATIC_DISCOVERY_RANGE', 'ROS_DOMAIN_ID'):
        monkeypatch.setenv(name, '')  # restored at the end
    own_domain()


def test_soak_loses_nothing_and_reads_its_bag_all_the_while() -> None:
    result = soak.run(MINUTES)
    assert result.samples > 60.0 * MINUTES * 862
    assert not any(result.lost.values())
    assert abs(result.drift_ms) < soak.DRIFT_LIMIT
    assert result.unreadable == []
    assert min(result.looks[reader] for reader in ('pneu-rig', 'mcap', 'rosbags')) >= 1
    assert '| lost' not in soak.text(result)


@pytest.mark.parametrize('name', FAULTS)
def test_what_has_to_happen_happens(name: str) -> None:
    finding = meet(name, KILLS)
    if not isinstance(finding, Finding):
        pytest.skip(finding)
    assert finding.held, finding.measured
    assert finding.measured in text({name: finding})
