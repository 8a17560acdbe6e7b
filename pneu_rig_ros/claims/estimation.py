"""Statement 10: Eq. 2 from the emulated sensors against the model's own friction."""

import numpy as np

from pneu_rig_ros.analysis.friction import ForceBalance, friction_zero_phase
from pneu_rig_ros.claims.experiments import INTERVAL, Laboratory, Stroke
from pneu_rig_ros.claims.findings import Finding, at_most
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.rig.sensors import SensorSet


def estimated_friction(laboratory: Laboratory) -> list[Finding]:
    """Statement 10: Eq. 2 from the emulated sensors against the model's own friction."""
    findings = []
    for stroke in laboratory.captions():
        name, law = stroke.experiment.cylinder, stroke.plant.model.friction
        error = estimation_error(stroke)
        share = error / law.breakaway_force
        findings.append(
            Finding(
                f'{name}: RMS error within 5 % of F_smax',
                f'{error:.2f} N, {share:.1%}',
                at_most(share, 0.05),
            )
        )
    return findings


ESTIMATED = round(20.0 / INTERVAL)
"""Samples of a stroke on which Eq. 2 is tried."""


def estimation_error(stroke: Stroke) -> float:
    """Return the RMS difference [N] of Eq. 2 on measured signals and the true friction."""
    configuration = load_configuration(stroke.experiment.cylinder)
    gas = configuration.model.gas
    sensors = SensorSet(configuration.sensors, gas.atmospheric_pressure, INTERVAL, seed=1)
    run = stroke.run
    columns = (run.position, run.velocity, run.pressure_1, run.pressure_2)
    truth = zip(*(column[:ESTIMATED] for column in columns), strict=True)
    position, _, pressure_1, pressure_2 = np.array([sensors.read(*row) for row in truth]).T
    balance = ForceBalance.of(configuration)
    estimate = friction_zero_phase(position, pressure_1, pressure_2, INTERVAL, balance)
    return float(np.sqrt(np.mean((estimate - run.friction_force[:ESTIMATED]) ** 2)))
