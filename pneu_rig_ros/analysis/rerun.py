"""A measured run once more, by a model: same conditions, same voltages, same start."""

from __future__ import annotations

import numpy as np

from pneu_rig_ros.analysis.comparison import Run
from pneu_rig_ros.analysis.friction import ForceBalance
from pneu_rig_ros.model.parameters import Model
from pneu_rig_ros.model.plant import Plant
from pneu_rig_ros.records import Recording
from pneu_rig_ros.rig import RigConfiguration

READING = 0.01
"""Length of the readings whose mean is the initial position [s]."""


def rerun(record: Recording, configuration: RigConfiguration, name: str | None = None) -> Run:
    """
    Simulate a record's run.

    The piston starts where the record does and the valves get the recorded voltages. What comes
    out are the true signals, without sensors.

    :param record: the measured run
    :param configuration: the rig under the conditions of the record
    :param name: of the run; that of the cylinder when not given
    :return: the simulated run, sample for sample beside the record
    """
    model = start_of(record, configuration.model)
    plant = Plant(model, configuration.effects)
    first = plant.state
    voltages = np.column_stack([record.voltage_1, record.voltage_2])[:-1]
    run = plant.run(voltages, record.interval)
    return Run(
        name or configuration.name,
        record.interval,
        np.concatenate([[first.position], run.position]),
        np.concatenate([[first.pressure_1], run.pressure_1]),
        np.concatenate([[first.pressure_2], run.pressure_2]),
        ForceBalance.of(configuration),
        model.cylinder.stroke,
    )


def start_of(record: Recording, model: Model) -> Model:
    """Return the model with the initial position and pressures of a record."""
    first = slice(0, max(1, round(READING / record.interval)))
    position = float(record.position[first].mean())
    operation = model.operation._replace(
        initial_position=min(max(position, 0.0), model.cylinder.stroke),
        initial_pressure_1=float(record.pressure_1[0]),
        initial_pressure_2=float(record.pressure_2[0]),
    )
    return model._replace(operation=operation)
