"""Statement 10: Eq. 2 from the emulated sensors against the model's own friction."""

from dataclasses import replace
from typing import Any

import numpy as np

from pneu_rig_ros.analysis.friction import ForceBalance, friction_zero_phase
from pneu_rig_ros.claims.experiments import CAPTIONS, INTERVAL, Laboratory, Stroke
from pneu_rig_ros.claims.findings import Finding, at_most
from pneu_rig_ros.claims.measures import in_slips
from pneu_rig_ros.claims.trends import LOAD_COMMAND, LOADS
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.rig.sensors import SensorSet

Floats = np.ndarray[Any, np.dtype[np.float64]]


def estimated_friction(laboratory: Laboratory) -> list[Finding]:
    """
    Statement 10: Eq. 2 from the emulated sensors against the model's own friction.

    At the captions' operating points M a is far below the friction, so these findings do not
    test the inertia. The last one does: in the slips with the largest load of Fig. 9, with exact
    sensors, for there the noise of the twice differentiated position exceeds M a.
    """
    findings = []
    for stroke in laboratory.captions():
        error = estimate(stroke, _readings(stroke)) - stroke.run.friction_force
        findings.append(_within(f'{stroke.experiment.cylinder}:', stroke, error, 0.05))
    if 'cylinder_1' in laboratory.cylinders:
        heavy = replace(CAPTIONS['cylinder_1'], u=LOAD_COMMAND, load_mass=LOADS[-1])
        findings.append(heavy_finding(laboratory.perform(heavy)))
    return findings


def heavy_finding(stroke: Stroke, mass_factor: float = 1.0) -> Finding:
    """Return how well Eq. 2 does in the slips with exact sensors; see ``estimate``."""
    error = estimate(stroke, _states(stroke), mass_factor) - stroke.run.friction_force
    says = f'cylinder_1 with {stroke.experiment.load_mass} kg, in the slips, exact sensors:'
    return _within(says, stroke, error[in_slips(stroke)], 0.02)


def _within(says: str, stroke: Stroke, error: Floats, bound: float) -> Finding:
    says = f'{says} RMS error within {bound:.0%} of F_smax'.replace('%', ' %')
    if not error.size:
        return Finding(says, 'no slips', np.nan)
    rms = float(np.sqrt(np.mean(error**2)))
    share = rms / stroke.plant.model.friction.breakaway_force
    return Finding(says, f'{rms:.2f} N, {share:.1%}', at_most(share, bound))


def estimate(stroke: Stroke, columns: Floats, mass_factor: float = 1.0) -> Floats:
    """
    Return the friction force [N] by Eq. 2, shape (n,).

    :param columns: position [m] and absolute pressures [Pa], shape (3, n)
    :param mass_factor: of M, to see what the inertia contributes [-]
    """
    model = stroke.plant.model
    cylinder, mass = model.cylinder, mass_factor * model.total_mass
    balance = ForceBalance(
        cylinder.cap_area, cylinder.rod_area, mass, model.gas.atmospheric_pressure
    )
    position, pressure_1, pressure_2 = columns
    return friction_zero_phase(position, pressure_1, pressure_2, INTERVAL, balance)


def _states(stroke: Stroke) -> Floats:
    return np.array([stroke.run.position, stroke.run.pressure_1, stroke.run.pressure_2])


def _readings(stroke: Stroke) -> Floats:
    """Return what the rig's sensors read, shape (3, n)."""
    configuration = load_configuration(stroke.experiment.cylinder)
    atmosphere = stroke.plant.model.gas.atmospheric_pressure
    sensors = SensorSet(configuration.sensors, atmosphere, INTERVAL, seed=1)
    run = stroke.run
    truth = zip(run.position, run.velocity, run.pressure_1, run.pressure_2, strict=True)
    return np.array([sensors.read(*row) for row in truth]).T[[0, 2, 3]]
