"""The model beside a rig: it stays with the piston when it is the true one; causal rests."""

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from pneu_rig_ros.analysis.motion import REST_SPEED, find_rests, rest_flags
from pneu_rig_ros.control.observer import (
    Measured,
    NoiseBand,
    Observer,
    RestDetector,
    residual,
)
from pneu_rig_ros.records import Recording, read_recording
from pneu_rig_ros.rig import RigConfiguration, load_configuration
from pneu_rig_ros.simulate import simulate

PAGE = Path(__file__).resolve().parents[2] / 'docs' / 'shadow.md'
COMMANDS = {'cylinder_1': 0.29, 'cylinder_2': 0.34, 'cylinder_3': 0.32}
INTERVAL = 1.16e-3
SECONDS, BAND = 20.0, 5.0
"""So short that no piston comes to its end stop, at which an offset of the sensor would count."""

MODELS: dict[str, dict[str, object]] = {
    'true': {},
    'supply 0.5 bar low': {'supply_pressure': 3.5e5},
    'friction without dwell': {'friction': 'revised_lugre'},
}
"""What is changed of a model, in the order of the columns of the page."""
ONE_IN_SHORT = [
    name if name == 'cylinder_2' else pytest.param(name, marks=pytest.mark.long)
    for name in COMMANDS
]


@cache
def recorded(name: str) -> Recording:
    with TemporaryDirectory() as folder:
        bag = simulate(load_configuration(name), COMMANDS[name], SECONDS, Path(folder) / 'bag')
        return read_recording(bag)


def samples(record: Recording) -> Iterator[tuple[tuple[float, float], Measured]]:
    """Yield the voltages held before each sample but the first, and the sample."""
    voltages = np.nan_to_num(np.column_stack([record.voltage_1, record.voltage_2]))
    signals = np.column_stack([record.position, record.pressure_1, record.pressure_2])
    for (u1, u2), reading in zip(voltages[:-1].tolist(), signals[1:].tolist(), strict=True):
        yield (u1, u2), Measured(*reading)


def outside(model: RigConfiguration, record: Recording) -> list[bool]:
    """Return of each sample that was compared whether its position was outside the band."""
    observer, band = Observer(model), NoiseBand(model.sensors, BAND)
    found = []
    for voltages, measured in samples(record):
        if (predicted := observer.push(voltages, measured)) is not None:
            x, _, p1, p2 = observer.origin
            left = residual(measured, predicted)
            found.append(band.outside(left, measured, Measured(x, p1, p2))[0])
    return found


def stated() -> dict[str, list[tuple[float, float]]]:
    """Return the ranges of shares that the page states, a list for each cylinder."""
    rows = re.findall(r'^\| cylinder (\d), .*? V \| (.*)', PAGE.read_text(), re.MULTILINE)
    return {
        f'cylinder_{number}': [
            (int(low) / 100.0, int(high) / 100.0)
            for low, high in re.findall(r'(\d+) to (\d+) %', shares)
        ]
        for number, shares in rows
    }


def test_a_slide_after_a_long_rest_is_predicted_to_its_end() -> None:
    """It is shorter than the horizon, so that the model is brought back at rests alone."""
    observer, restarts, speeds = Observer(load_configuration('cylinder_2')), 0, []
    for voltages, measured in samples(recorded('cylinder_2')):
        observer.push(voltages, measured)
        if observer.restarts > restarts:
            restarts = observer.restarts
            speeds.append(abs(observer.origin[1]))
    assert len(speeds) > 5
    assert max(speeds) < 2.0 * REST_SPEED


@pytest.mark.parametrize('model', MODELS)
@pytest.mark.parametrize('name', ONE_IN_SHORT)
def test_position_is_outside_the_band_as_often_as_the_page_says(name: str, model: str) -> None:
    record = recorded(name)
    found = outside(load_configuration(name, **MODELS[model]), record)
    assert len(found) > 0.9 * record.position.size
    low, high = stated()[name][list(MODELS).index(model)]
    # another processor rounds differently, which acts like another draw of the noise
    assert low - 0.05 < np.mean(found) < high + 0.05


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
