"""
What a part does when the signals around it are the measured ones, against what it was seen to do.

Chambers get the measured motion (and voltages), and their pressures are predicted from the first
sample on. Friction gets motion and pressures. Valves get voltages and motion, and the measured
pressures again and again: how far the pressures get in a short time is a mass flow.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, minimum_filter1d
from scipy.signal import savgol_filter

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.parts.part import CHAMBERS, FRICTION, Part
from pneu_rig_ros.gap.parts.recording import Recording
from pneu_rig_ros.model import chambers, follow, piston
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.compiled import plain
from pneu_rig_ros.model.compiled_model import air
from pneu_rig_ros.model.effect import READING_BALANCES
from pneu_rig_ros.model.parameters import COULOMB_VISCOUS, Friction
from pneu_rig_ros.model.plant import Trajectory
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE

Floats = NDArray[np.float64]

TOLERANCE = 5e-5
"""Local error of a prediction [-]: 15 Pa at 1.4 MPa."""
FILLS = 2
"""Runs with the initial pressures corrected in between."""
FLOW_SPAN = 0.1
"""Time in which the pressures say how much has flowed [s]."""
FLOW_SMOOTHING = 0.03
"""Window of the fits that smooth the pressures the valves get [s]."""

VOLTAGE_STEP = 0.1
"""Change of a voltage about an end of a span from which on the span says nothing [V]."""


@dataclass(frozen=True)
class Channel:
    """
    One signal of a part, as it was seen less as it was predicted.

    :param name: of the signal
    :param unit: SI
    :param gap: at each sample but the first, shape (m,); NaN where it says nothing
    :param noise: standard deviation of the gap of a true hypothesis, shape (m,)
    :param measured: the signal itself, shape (m,)
    """

    name: str
    unit: str
    gap: Floats
    noise: Floats
    measured: Floats

    @property
    def predicted(self) -> Floats:
        """The prediction, shape (m,)."""
        return self.measured - self.gap


def compare(part: Part, hypothesis: Hypothesis, recording: Recording) -> list[Channel]:
    """Return measured less predicted of each signal of a part, under the run's conditions."""
    known = {name: value for name, value in recording.conditions.items()
             if f'operation.{name}' not in part.refit}  # fmt: skip
    hypothesis = hypothesis.under(known)
    if part.kind == CHAMBERS:
        return _chambers(part, hypothesis, recording)
    if part.kind == FRICTION:
        return [_friction(part, hypothesis, recording)]
    return _valves(part, hypothesis, recording)


def drive(
    part: Part, hypothesis: Hypothesis, recording: Recording, fill: Floats,
    imposed: NDArray[np.int64],
) -> Trajectory:  # fmt: skip
    """
    Return the run of a part along a recording.

    :param fill: p1, p2 at the first sample [Pa]
    :param imposed: what is imposed at each sample but the last, see ``Plant.follow``
    """
    bias = np.zeros((recording.size, 2))
    if any(library.load(name).balance in READING_BALANCES for name in hypothesis.effects):
        rough = _follow(part, hypothesis, recording, fill, imposed, bias)
        bias[1:, 0] = rough.position_reading - rough.position
        bias[0] = bias[1]
    return _follow(part, hypothesis, recording, fill, imposed, bias)


def _follow(
    part: Part, hypothesis: Hypothesis, recording: Recording, fill: Floats,
    imposed: NDArray[np.int64], bias: Floats,
) -> Trajectory:  # fmt: skip
    model = hypothesis.model
    position = np.clip(recording.position - bias[:, 0], 0.0, model.cylinder.stroke)
    pressures = _seen_pressures(part, hypothesis, recording)
    measured = np.zeros((recording.size - 1, 4))
    measured[:, 0] = position[:-1]
    measured[:, 1] = np.diff(position) / recording.interval
    measured[:, 2:] = pressures[:-1]
    highest = float(max(pressures.max(), fill.max()))
    operation = model.operation._replace(
        initial_position=float(position[0]), initial_pressure_1=float(fill[0]),
        initial_pressure_2=float(fill[1]),
        supply_pressure=highest if part.kind == FRICTION or part.shut
        else model.operation.supply_pressure,
    )  # fmt: skip
    if part.kind != FRICTION:
        model = model._replace(friction=_loose(model.friction))
    plant = hypothesis.plant_of(model._replace(operation=operation))
    plant.tolerance, plant.longest_step = TOLERANCE, recording.interval
    actions, rests = _rests(hypothesis, recording)
    return plant.follow(
        _voltages(part, recording), recording.interval, actions | imposed, measured, rests
    )


def _loose(law: Friction) -> Friction:
    """Return a seal with nothing to integrate, for an imposed motion whose force is not asked."""
    return law._replace(
        model=COULOMB_VISCOUS, coulomb_force=1e5, breakaway_force=1e5, element_limit=(),
        element_stiffness=(1e2,), viscous_coefficient=0.0, micro_viscous_coefficient=0.0,
    )  # fmt: skip


def _voltages(part: Part, recording: Recording) -> Floats:
    voltages = np.full((recording.size - 1, 2), CENTRE_VOLTAGE)
    for column in (0, 1):
        if not part.shut and f'voltage_{column + 1}' in recording:
            voltages[:, column] = recording[f'voltage_{column + 1}'][:-1]
    return voltages


def _seen_pressures(part: Part, hypothesis: Hypothesis, recording: Recording) -> Floats:
    """Return p1, p2 [Pa] as the valves or the seal get them, shape (n, 2)."""
    pressures = recording.pressures(hypothesis.model.gas.atmospheric_pressure)
    if part.kind in (CHAMBERS, FRICTION):
        return pressures
    window = 2 * round(0.5 * FLOW_SMOOTHING / recording.interval) + 1
    smooth: Floats = savgol_filter(pressures, max(window, 5), 2, axis=0)
    return smooth


def _rests(hypothesis: Hypothesis, recording: Recording) -> tuple[NDArray[np.int64], Floats]:
    """Return when the piston comes to rest and breaks away, for the dwell clock."""
    law, speed = hypothesis.model.friction, np.abs(recording.velocity)
    actions, begins = np.zeros(speed.size, dtype=np.int64), np.zeros(speed.size)
    flags = np.where(speed > law.start_velocity, 1, np.where(speed < law.stop_velocity, -1, 0))
    resting = True
    for index in np.flatnonzero(flags):
        if resting and flags[index] > 0:
            actions[index], resting = follow.BREAK, False
        elif not resting and flags[index] < 0:
            actions[index], resting = follow.REST, True
            begins[index] = index * recording.interval
    return actions, begins


def _chambers(part: Part, hypothesis: Hypothesis, recording: Recording) -> list[Channel]:
    outside = hypothesis.model.gas.atmospheric_pressure
    seen = recording.pressures(outside)
    imposed = np.full(recording.size - 1, follow.MOTION, dtype=np.int64)
    fill, scale = seen[0].copy(), np.ones(2)
    for _ in range(FILLS if 'initial_pressure' in part.each_recording else 1):
        fill = fill * scale
        run = drive(part, hypothesis, recording, fill, imposed)
        readings = np.column_stack([run.pressure_1_reading, run.pressure_2_reading])
        true = np.column_stack([run.pressure_1, run.pressure_2])
        if part.each_recording:
            target = seen[1:] - (readings - true)
            scale = np.sum(target * true, axis=0) / np.sum(true**2, axis=0)
    # pressures are all but proportional to the initial ones: the last correction needs no run
    predicted = readings + (scale - 1.0) * true
    compress = _compression(hypothesis, recording)
    return [
        Channel(
            name, 'Pa', seen[1:, i] - predicted[:, i],
            np.hypot(recording.noise[name], compress[:, i]), seen[1:, i],
        )
        for i, name in enumerate(('pressure_1', 'pressure_2')) if name in recording
    ]  # fmt: skip


def _compression(hypothesis: Hypothesis, recording: Recording) -> Floats:
    """Return what the noise of the imposed position does to p1, p2 [Pa], shape (n - 1, 2)."""
    model = hypothesis.model
    k, stroke = model.gas.heat_capacity_ratio, model.cylinder.stroke
    volumes = _volumes(hypothesis, np.clip(recording.position[1:], 0.0, stroke))
    areas = np.array([model.cylinder.cap_area, model.cylinder.rod_area])
    pressures = recording.pressures(model.gas.atmospheric_pressure)[1:]
    noise: Floats = k * pressures * areas / volumes * recording.noise.get('position', 0.0)
    return noise


def _volumes(hypothesis: Hypothesis, position: Any) -> Floats:
    return np.column_stack(plain(chambers.volumes)(position, hypothesis.model.cylinder))


def _friction(part: Part, hypothesis: Hypothesis, recording: Recording) -> Channel:
    model = hypothesis.model
    pressures = recording.pressures(model.gas.atmospheric_pressure)
    imposed = np.full(recording.size - 1, follow.MOTION | follow.PRESSURES, dtype=np.int64)
    run = drive(part, hypothesis, recording, pressures[0], imposed)
    force: Any = plain(piston.driving_force)
    driving = force(pressures[1:, 0], pressures[1:, 1], model.cylinder, air(model.gas))
    if 'force' in recording:
        measured = recording['force'][1:] + driving
    else:
        measured = recording['friction'][1:]
    gap = measured - run.friction_force
    if 'force_offset' in part.each_recording:
        offset = float(np.sum(recording.weights * gap))
        gap, measured = gap - offset, measured - offset
    return Channel('friction', 'N', gap, _force_noise(hypothesis, recording), measured)


def _force_noise(hypothesis: Hypothesis, recording: Recording) -> Floats:
    """Return the noise of the measured friction [N], shape (n - 1,)."""
    cylinder, noise = hypothesis.model.cylinder, recording.noise
    if 'force' in recording:
        areas = cylinder.cap_area, cylinder.rod_area
        thrusts = [a * noise.get(f'pressure_{i}', 0.0) for i, a in enumerate(areas, 1)]
        reading = float(np.linalg.norm([noise['force'], *thrusts]))
    else:
        reading = noise['friction']
    return np.full(recording.size - 1, reading)


def _valves(part: Part, hypothesis: Hypothesis, recording: Recording) -> list[Channel]:
    model = hypothesis.model
    span = max(1, round(FLOW_SPAN / recording.interval))
    imposed = np.full(recording.size - 1, follow.MOTION, dtype=np.int64)
    imposed[::span] |= follow.PRESSURES
    smooth = _seen_pressures(part, hypothesis, recording)
    run = drive(part, hypothesis, recording, smooth[0], imposed)
    ends = np.arange(span, recording.size, span)
    reached = np.column_stack([run.pressure_1, run.pressure_2])[ends - 1]
    stroke, gas = model.cylinder.stroke, model.gas
    volumes = _volumes(hypothesis, np.clip(recording.position[ends], 0.0, stroke))
    energy = gas.heat_capacity_ratio * gas.gas_constant * gas.supply_temperature
    share = volumes / energy / (span * recording.interval)
    gap, change = (smooth[ends] - reached) * share, (smooth[ends] - smooth[ends - span]) * share
    window = max(2 * round(0.5 * FLOW_SMOOTHING / recording.interval) + 1, 5)
    # a fit of a parabola leaves 1.5 / sqrt(samples) of the noise of its middle
    left = 1.5 * np.sqrt(2.0 / window)
    for i in (0, 1):
        gap[_stepped(recording, f'voltage_{i + 1}', ends, span, window), i] = np.nan
    flows = [
        _flow(f'flow_{i + 1}', name, ends, gap[:, i], change[:, i], left * share[:, i], recording)
        for i, name in enumerate(('pressure_1', 'pressure_2'))
        if name in recording and f'voltage_{i + 1}' in recording
    ]
    told = [one for one in flows if np.isfinite(one.gap).any()]
    if not told:
        raise RigError(
            f'{recording.name}: no flow can be told, for the voltages step by more than '
            f'{VOLTAGE_STEP:g} V at least every {FLOW_SPAN:g} s'
        )
    return told


def _stepped(
    recording: Recording, name: str, ends: NDArray[np.intp], span: int, window: int
) -> NDArray[np.bool_]:
    """Return the spans at whose ends the voltage steps, which smoothed pressures round off."""
    if name not in recording:
        return np.zeros(ends.size, dtype=np.bool_)
    voltage, size = recording[name], 2 * window + 1
    steps = maximum_filter1d(voltage, size) - minimum_filter1d(voltage, size) > VOLTAGE_STEP
    stepped: NDArray[np.bool_] = steps[ends] | steps[ends - span]
    return stepped


def _flow(
    name: str, pressure: str, ends: NDArray[np.intp], gap: Floats, change: Floats,
    share: Floats, recording: Recording,
) -> Channel:  # fmt: skip
    """Return a mass flow as a channel, NaN between the ends of its spans."""
    columns = np.full((3, recording.size - 1), np.nan)
    columns[:, ends - 1] = gap, share * recording.noise[pressure], change
    return Channel(name, 'kg/s', *columns)
