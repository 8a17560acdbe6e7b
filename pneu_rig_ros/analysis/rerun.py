"""A measured run once more, by a model: same conditions, same voltages, same start."""

from __future__ import annotations

import numpy as np

from pneu_rig_ros.model.parameters import Model
from pneu_rig_ros.model.plant import Plant
from pneu_rig_ros.records import Recording
from pneu_rig_ros.records.recording import WHOLE
from pneu_rig_ros.rig import RigConfiguration

READING = 0.01
"""Length of the readings whose mean is the initial position [s]."""


def rerun(
    recording: Recording, configuration: RigConfiguration, name: str | None = None
) -> Recording:
    """
    Simulate a recorded run.

    The piston starts where the recording does and the valves get the recorded voltages. What comes
    out are the true signals, without sensors.

    :param recording: the measured run
    :param configuration: the rig under the conditions of the run
    :param name: of the new one; that of the cylinder when not given
    :return: the simulated run, sample for sample beside the measured one
    """
    model = start_of(recording, configuration.model)
    plant = Plant(model, configuration.effects)
    first = plant.state
    voltages = np.column_stack([recording.voltage_1, recording.voltage_2])
    run = plant.run(voltages[:-1], recording.interval)
    signals = {signal: np.concatenate([[getattr(first, signal)], getattr(run, signal)])
               for signal in WHOLE}  # fmt: skip
    signals |= {'voltage_1': voltages[:, 0], 'voltage_2': voltages[:, 1]}
    return Recording(
        name or configuration.name, recording.start_ns, recording.interval_ns, signals,
        configuration=configuration,
    )  # fmt: skip


def start_of(recording: Recording, model: Model) -> Model:
    """Return the model with the initial position and pressures of a recording."""
    first = slice(0, max(1, round(READING / recording.interval)))
    position = float(recording.position[first].mean())
    operation = model.operation._replace(
        initial_position=min(max(position, 0.0), model.cylinder.stroke),
        initial_pressure_1=float(recording.pressure_1[0]),
        initial_pressure_2=float(recording.pressure_2[0]),
    )
    return model._replace(operation=operation)
