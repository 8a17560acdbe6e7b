"""The causal detector decides as the offline one does, as late as its means are long."""

import numpy as np
import pytest

from pneu_rig_ros.analysis.motion import find_rests, rest_flags
from pneu_rig_ros.control.observer import RestDetector

INTERVAL = 1.16e-3


@pytest.mark.parametrize('noise', [2.9e-5, 3e-4])
def test_causal_and_offline_detector_agree(noise: float) -> None:
    time = np.arange(0.0, 12.0, INTERVAL)
    position = 0.05 + 0.02 * np.clip((time % 4.0) - 2.0, 0.0, 1.0) + 0.02 * (time // 4.0)
    read = position + np.random.default_rng(0).normal(0.0, noise, time.size)
    offline = rest_flags(find_rests(read, INTERVAL, noise), time.size)
    detector = RestDetector(INTERVAL, noise)
    late = detector.size
    causal = []
    for place in read.tolist():
        detector.push(place)
        causal.append(detector.resting)
    assert np.mean(np.array(causal[late:]) == offline[:-late]) > 0.95
    assert 0.6 < offline.mean() < 0.8


def test_noise_does_not_set_a_piston_off() -> None:
    detector, noise = RestDetector(INTERVAL), np.random.default_rng(0).normal(0.0, 2.9e-5, 50_000)
    speeds = [detector.push(place) for place in (0.1 + noise).tolist()]
    assert detector.resting
    assert speeds[: 2 * detector.size - 1] == [None] * (2 * detector.size - 1)
    assert max(speed for speed in speeds if speed is not None) < 3e-3


def test_forgets() -> None:
    detector = RestDetector(INTERVAL)
    for place in np.linspace(0.0, 0.1, 500).tolist():
        detector.push(place)
    assert not detector.resting
    detector.reset()
    assert detector.resting
    assert detector.push(0.1) is None
