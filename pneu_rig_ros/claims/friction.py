"""Statements 9 and 10: static friction against dwell time, and Eq. 2 against the model."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from pneu_rig_ros.analysis.friction import ForceBalance, friction_zero_phase
from pneu_rig_ros.analysis.motion import find_rests, rest_flags
from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.claims.experiments import CAPTIONS, INTERVAL, Laboratory, Stroke
from pneu_rig_ros.claims.findings import Finding, at_most, numbers, rises_throughout
from pneu_rig_ros.claims.trends import LOAD_COMMAND, LOADS
from pneu_rig_ros.model.parameters import Friction
from pneu_rig_ros.model.plant import Plant, PlantState
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.rig.sensors import SensorSet
from pneu_rig_ros.rig.valve_drive import valve_voltages


def dwell_law(laboratory: Laboratory) -> Iterator[Finding]:
    """Statement 9 (Fig. 3): Eq. 16 recovered from the strokes, and from rests of chosen length."""
    yield from in_strokes(laboratory)
    for name in laboratory.cylinders:
        own, (waits, peaks) = laboratory.perform(CAPTIONS[name]), pauses(laboratory, name)
        yield along_equation_16(own, f'{name}, after pauses', waits, peaks)
        says = f'{name}, after pauses: peaks grow with the dwell'
        text = f'{numbers(peaks, ".1f")} N after {numbers(waits, ".1f")} s'
        yield Finding(says, text, rises_throughout(peaks))


def in_strokes(laboratory: Laboratory) -> Iterator[Finding]:
    """Yield what the strokes of the captions say of Eq. 16, as in Fig. 3."""
    for own in laboratory.captions():
        where = f'{own.experiment.cylinder}, in the stroke'
        yield along_equation_16(own, where, own.dwells, static_peaks(own)[1:])


def static_peaks(stroke: Stroke) -> Floats:
    """
    Return the static friction force [N] of each cycle, shape (n,).

    As in Fig. 3, the largest friction force before the onset of sliding; the viscous friction of
    the slip after it does not count.
    """
    force, peaks = stroke.run.friction_force, []
    for cycle in stroke.cycles:
        onset = round(cycle.breakaway_time / INTERVAL)
        rest = onset - round(cycle.dwell / INTERVAL)
        peaks.append(float(force[rest : onset + 1].max()))
    return np.array(peaks)


def along_equation_16(stroke: Stroke, where: str, waits: Floats, peaks: Floats) -> Finding:
    """Compare peaks [N] after dwells [s] with Eq. 16."""
    law = stroke.plant.model.friction
    span = law.breakaway_force - law.coulomb_force
    says = f'{where}: peaks along Eq. 16 (RMS within 20 % of F_smax - F_c)'
    if not (len(peaks) and span > 0.0):
        return Finding(says, 'no cycles' if span > 0.0 else 'F_smax = F_c', np.nan)
    error = float(np.sqrt(np.mean((peaks - equation_16(waits, law)) ** 2)))
    return Finding(says, f'{error:.2f} N, {error / span:.0%}', at_most(error, 0.2 * span))


def equation_16(waits: Floats, law: Friction) -> Floats:
    """Return F_s(t_D) [N] of Eq. 16 for dwell times [s]."""
    span = law.breakaway_force - law.coulomb_force
    return law.breakaway_force - span * np.exp(-law.dwell_coefficient * waits**law.dwell_exponent)


PAUSES = (1.0, 3.0, 10.0, 30.0)
"""Rests between pushes in the experiment with pauses [s]."""
RUN_IN = 3
"""Strokes to and fro before a pause, so that the rest before them no longer counts."""
RUN_IN_COMMAND = 0.5
"""[V]"""


def pauses(laboratory: Laboratory, name: str) -> tuple[Floats, Floats]:
    """
    Return dwell times [s] and the friction peaks [N] that end them.

    As friction is measured against dwell time elsewhere: run in, stop, wait, push.
    """
    plant = laboratory.plant(replace(CAPTIONS[name], u=0.0))
    waits, peaks = np.array([push_after(plant, pause) for pause in PAUSES]).T
    return waits, peaks


def push_after(plant: Plant, pause: float) -> tuple[float, float]:
    """Return the dwell [s] and the friction peak [N] of a breakaway after a pause [s]."""
    stroke = plant.model.cylinder.stroke
    push, shut = valve_voltages(0.35), valve_voltages(0.0)
    out, back = valve_voltages(RUN_IN_COMMAND), valve_voltages(-RUN_IN_COMMAND)
    for _ in range(RUN_IN):
        advance(plant, out, 30.0, lambda state: state.position > 0.9 * stroke)
        advance(plant, back, 30.0, lambda state: state.position < 0.1 * stroke)
    advance(plant, push, 30.0, lambda state: state.position > 0.25 * stroke)
    advance(plant, shut, 10.0, lambda state: abs(state.velocity) < RESTING_SPEED)
    rest_begins, place = plant.state.time, plant.state.position
    advance(plant, shut, pause)
    peak = advance(plant, push, 30.0, lambda state: state.position > place + SLID)
    return plant.state.time - rest_begins, peak


RESTING_SPEED = 2e-4
"""A piston slower than this has come to rest [m/s]."""
SLID = 1.5e-3
"""A piston that went this far is sliding: more than any presliding [m]."""
BLOCK = 40
"""Samples between two evaluations of the condition."""


def advance(
    plant: Plant,
    voltages: tuple[float, ...],
    longest: float,
    until: Callable[[PlantState], bool] = lambda _: False,
) -> float:
    """
    Hold the voltages [V] until a condition holds, but no longer than ``longest`` [s].

    :returns: the largest friction force on the way [N]
    """
    peak, block = 0.0, np.tile(voltages, (BLOCK, 1))
    for _ in range(round(longest / INTERVAL / BLOCK)):
        peak = max(peak, float(plant.run(block, INTERVAL).friction_force.max()))
        if until(plant.state):
            break
    return peak


def estimated_friction(laboratory: Laboratory) -> Iterator[Finding]:
    """
    Statement 10: Eq. 2 from the emulated sensors against the model's own friction.

    At the captions' operating points M a is far below the friction, so these findings do not
    test the inertia. The last one does: in the slips with the largest load of Fig. 9, with exact
    sensors, for there the noise of the twice differentiated position exceeds M a.
    """
    for stroke in laboratory.captions():
        error = estimate(stroke, _readings(stroke)) - stroke.run.friction_force
        yield _within(f'{stroke.experiment.cylinder}:', stroke, error, 0.05)
    if 'cylinder_1' in laboratory.cylinders:
        heavy = replace(CAPTIONS['cylinder_1'], u=LOAD_COMMAND, load_mass=LOADS[-1])
        yield heavy_finding(laboratory.perform(heavy))


def heavy_finding(stroke: Stroke, mass_factor: float = 1.0) -> Finding:
    """Return how well Eq. 2 does in the slips with exact sensors; see ``estimate``."""
    run = stroke.run
    states = np.array([run.position, run.pressure_1, run.pressure_2])
    error = estimate(stroke, states, mass_factor) - run.friction_force
    says = f'cylinder_1 with {stroke.experiment.load_mass} kg, in the slips, exact sensors:'
    at_rest = rest_flags(find_rests(run.position, INTERVAL), run.time.size)
    return _within(says, stroke, error[~at_rest], 0.02)


def _within(says: str, stroke: Stroke, error: Floats, bound: float) -> Finding:
    says = f'{says} RMS error within {100 * bound:.0f} % of F_smax'
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


def _readings(stroke: Stroke) -> Floats:
    """Return what the rig's sensors read, shape (3, n)."""
    configuration = load_configuration(stroke.experiment.cylinder)
    atmosphere = stroke.plant.model.gas.atmospheric_pressure
    sensors = SensorSet(configuration.sensors, atmosphere, INTERVAL, seed=1)
    run = stroke.run
    truth = zip(run.position, run.velocity, run.pressure_1, run.pressure_2, strict=True)
    return np.array([sensors.read(*row) for row in truth]).T[[0, 2, 3]]
