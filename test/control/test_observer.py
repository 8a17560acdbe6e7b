"""The model beside a rig: it stays with the measured piston when it is the true one."""

import re
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from pneu_rig_ros.analysis.motion import REST_SPEED
from pneu_rig_ros.control.observer import Measured, NoiseBand, Observer, residual
from pneu_rig_ros.records import Recording, read_recording
from pneu_rig_ros.rig import RigConfiguration, load_configuration
from pneu_rig_ros.simulate import simulate

PAGE = Path(__file__).resolve().parents[2] / 'docs' / 'shadow.md'
COMMANDS = {'cylinder_1': 0.29, 'cylinder_2': 0.34, 'cylinder_3': 0.32}
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


def outside(model: RigConfiguration, record: Recording) -> list[bool]:
    """Return of each sample that was compared whether its position was outside the band."""
    voltages = np.nan_to_num(np.column_stack([record.voltage_1, record.voltage_2]))
    observer, band = Observer(model), NoiseBand(model.sensors, BAND)
    found = []
    for now, *reading in zip(
        voltages[:-1],
        record.position[1:],
        record.pressure_1[1:],
        record.pressure_2[1:],
        strict=True,
    ):
        measured = Measured(*map(float, reading))
        if (predicted := observer.push((float(now[0]), float(now[1])), measured)) is not None:
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
    record = recorded('cylinder_2')
    voltages = np.nan_to_num(np.column_stack([record.voltage_1, record.voltage_2]))
    observer, restarts, speeds = Observer(load_configuration('cylinder_2')), 0, []
    for now, *reading in zip(
        voltages[:-1],
        record.position[1:],
        record.pressure_1[1:],
        record.pressure_2[1:],
        strict=True,
    ):
        observer.push((float(now[0]), float(now[1])), Measured(*map(float, reading)))
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
