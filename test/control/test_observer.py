"""The model beside a rig: it stays with the measured piston when it is the true one."""

from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.control.observer import Measured, Observer
from pneu_rig_ros.control.residual import NoiseBand, residual
from pneu_rig_ros.records import read_record
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.simulate import simulate

COMMANDS = {'cylinder_1': 0.29, 'cylinder_2': 0.34, 'cylinder_3': 0.32}
SECONDS, BAND = 25.0, 5.0


@pytest.mark.parametrize('name', COMMANDS)
def test_true_model_is_inside_the_band_most_of_the_time(name: str, tmp_path: Path) -> None:
    rig = load_configuration(name)
    record = read_record(simulate(rig, COMMANDS[name], SECONDS, tmp_path / 'bag'))
    voltages = np.nan_to_num(np.column_stack([record.voltage_1, record.voltage_2]))
    observer, band = Observer(rig), NoiseBand(rig.sensors, BAND)
    outside = []
    for now, *reading in zip(
        voltages[:-1], record.position[1:], record.pressure_1[1:], record.pressure_2[1:],
        strict=True,
    ):  # fmt: skip
        measured = Measured(*map(float, reading))
        if (predicted := observer.push((float(now[0]), float(now[1])), measured)) is not None:
            x, _, p1, p2 = observer.origin
            left = residual(measured, predicted)
            outside.append(band.outside(left, measured, Measured(x, p1, p2))[0])
    assert len(outside) > 0.9 * record.position.size
    assert np.mean(outside) < 0.35
