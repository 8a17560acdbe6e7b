"""
Recordings as runs of a system: checked, with their noise, spans, conditions and open balances.

A balance needs values of the system's file, 'section.key', and signals, 'signal name', that are
recorded or constant.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.inputs.system import System
from pneu_rig_ros.diagnosis.measured.reading import Noise, Span, without_clipped, without_outliers
from pneu_rig_ros.diagnosis.measured.run import LARGEST_DELAY, Run
from pneu_rig_ros.diagnosis.residuals.balances import BALANCES
from pneu_rig_ros.diagnosis.residuals.nuisances import (
    CLOCK_OFFSET,
    FORCE_OFFSET,
    INITIAL_TEMPERATURE,
    USUAL,
)
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.parameters import FADES_WHILE_SLIDING, REVISED_LUGRE_DWELL, Operation
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE
from pneu_rig_ros.records.conditions import apply_conditions, check_plausible
from pneu_rig_ros.records.reading_noise import reading_noise
from pneu_rig_ros.records.recording import PRESSURES, Recording
from pneu_rig_ros.rig.configuration import FRICTION_LEVEL
from pneu_rig_ros.rig.sensors import Sensors, sensor_noise

SATURATED = 0.5
"""Largest share of a recording that a signal may be at the upper end of its span [-]."""
LEAST_DURATION = 1.0
"""A shorter recording is refused [s]."""
LONGEST_GAP = 0.025
"""Samples that are missing for longer leave nothing of a slip: half its duration [s]."""
LONGEST_IMPOSED_GAP = 0.5
"""
The same of a motion that a bench imposes, which goes on as it did and has no slips [s]: a fifth of
a stroke of 40 mm at 15 mm/s, within which it is a line.
"""
LEAST_GAP = 5
"""Samples of a slower signal that may be missing in succession."""
ESTIMATED = ('velocity', 'friction')
"""Signals that are not used: the estimator of the rig, e.g., begins later."""
TEMPERATURE_DRIFT = 2.0
"""By how much the temperature of a vessel may drift in a recording, as that of a room does [K]."""
FRICTION_ERROR = 0.03
"""
By how much the friction of a rig differs from one recording to the next, where not even its
sensors are calibrated [-]: seals put in again differ by 5 to 13 %, from cycle to cycle by 2 to 3 %
(recordings of E. Zillen, TU Delft).
"""
SLOWEST_SAMPLING = 0.02
"""At a longer interval the breakaways of a free piston do not show [s]."""
FRICTION_KEYS = (
    ('coulomb_force', 'element_stiffness'),
    ('breakaway_force', 'stribeck_velocity', 'stribeck_exponent'),
    ('film_velocity', 'film_time_acceleration', 'film_time_deceleration', 'film_time_dwell'),
    ('dwell_exponent', 'dwell_coefficient'),
)
"""Parameters that each of the friction laws needs beside those of the laws before it."""


def prepare_runs(
    recordings: Sequence[Recording], system: System, paths: Sequence[Path]
) -> list[Run]:
    """Return recordings, prepared for a system; RigError where one cannot be of the system."""
    pairs = list(zip(recordings, paths, strict=True))
    runs = [prepare_run(recording, system, path) for recording, path in pairs]
    if not system.constant_volume:
        return runs
    lengths = {path: sum(r.duration for r, of in pairs if of == path) for path in paths}
    return [with_drift(run, system, lengths[path]) for run, path in zip(runs, paths, strict=True)]


def with_unknown_temperature(run: Run) -> Run:
    """Return a run that begins while the gas is not at the temperature of the supply."""
    return replace(run, temperature_sd=run.temperature_sd or USUAL[INITIAL_TEMPERATURE])


def with_drift(run: Run, system: System, duration: float) -> Run:
    """Return a run of a vessel, the temperature of which drifts over a duration [s]."""
    model = system.hypothesis.model
    gas, dead = model.gas, (model.cylinder.cap_dead_volume, model.cylinder.rod_dead_volume)
    rate = TEMPERATURE_DRIFT / gas.supply_temperature / duration
    enthalpy = gas.heat_capacity_ratio * gas.gas_constant * gas.supply_temperature
    sources = rate * run.pressures.mean(axis=0) * np.array(dead) / enthalpy
    drift = {f'gas_{i}': float(source) for i, source in enumerate(sources, start=1)}
    return replace(run, repeatability={**drift, **run.repeatability})


def prepare_run(recording: Recording, system: System, path: Path) -> Run:
    """Return a recording, prepared for a system; RigError where it cannot be of the system."""
    missing = lacks(system, recording)
    balances = frozenset(name for name, reasons in missing.items() if not reasons)
    if not balances:
        reasons = '; '.join(f'{name} needs {names}' for name, names in missing.items())
        raise RigError(f'{path}: no balance can be compared: {reasons}')
    model, conditions, sensors = system.hypothesis.model, recording.conditions, system.sensors
    zero, span = conditions.get('atmospheric_pressure', model.gas.atmospheric_pressure), Span()
    if sensors is not None:
        span = Span(sensors.position_span, zero, zero + sensors.pressure_span)
    _check_signals(recording, system, balances, span, path)
    stated = {name: value for name, value in conditions.items() if name in Operation._fields}

    def signal(name: str, default: float) -> Floats:
        if name in recording:
            return np.array(recording[name])
        return np.full(recording.size, system.fixed.get(name, default))

    if system.shut or not recording.driven:
        voltages = np.full((recording.size - 1, 2), CENTRE_VOLTAGE)
    else:
        voltages = np.column_stack([recording.voltage_1, recording.voltage_2])[:-1]
    deviations, noise = system.each_recording, _noise(recording, sensors, zero)
    worn = system.rig is not None and system.uncalibrated  # no such rig is kept like new
    differs = dict(system.repeatability)
    level_ratio = max(FRICTION_ERROR if worn else 0.0, differs.pop(FRICTION_LEVEL, 0.0))
    position, notes, force = signal('position', 0.0), recording.notes, None
    if on_bench(recording):
        force, recorded = np.array(recording['force']), position
        position = without_outliers(recorded, noise.position)
        if count := int(np.count_nonzero(recorded != position)):
            notes = *notes, f'{count} wrong position reading{"s" * (count > 1)} replaced'
    run = Run(
        recording.name,
        recording.interval,
        position,
        np.column_stack([signal(name, zero) for name in PRESSURES]),
        voltages,
        model.operation._replace(**stated),
        zero,
        model.cylinder.stroke,
        (model.cylinder.cap_area, model.cylinder.rod_area),
        noise,
        span,
        missing,
        force,
        deviations.get(FORCE_OFFSET, 0.0),
        deviations.get(CLOCK_OFFSET, 0.0),
        deviations.get(INITIAL_TEMPERATURE, 0.0),
        differs,
        level_ratio * model.friction.coulomb_force,
        notes=notes,
    )
    return run.with_delay(0.0) if run.delay_sd > 0.0 else run


def _noise(recording: Recording, sensors: Sensors | None, zero: float) -> Noise:
    """
    Return the noise that the signals show, at least that of the data sheet.

    :param zero: of the pressure sensors, the pressure of the atmosphere [Pa]
    """
    least: dict[str, float] = {}
    if sensors is not None:
        position, pressure = sensor_noise(sensors)
        least = {'position': position, 'pressure_1': pressure, 'pressure_2': pressure}

    def noise(name: str) -> float:
        if name not in recording:
            return 0.0
        if name not in least:
            return recording.noise[name]
        low = zero if name in PRESSURES else 0.0
        return reading_noise(without_clipped(recording[name], low), least[name])

    return Noise(*map(noise, ('position', *PRESSURES, 'force')))


def _check_signals(
    recording: Recording, system: System, balances: frozenset[str], span: Span, path: Path
) -> None:
    """Raise RigError for signals without information, or that cannot be of the system."""
    needed = LEAST_DURATION + 2.0 * LARGEST_DELAY * system.each_recording.get(CLOCK_OFFSET, 0.0)
    if recording.duration < needed:
        raise RigError(f'{path}: {recording.duration:.2f} s, at least {needed:g} s needed')
    if recording.interval > SLOWEST_SAMPLING and balances == frozenset(BALANCES):
        raise RigError(
            f'{path}: a sample every {1e3 * recording.interval:g} ms, at most '
            f'{1e3 * SLOWEST_SAMPLING:g} ms allowed to see the piston break away'
        )
    _check_gaps(recording, path)
    for name in ('position', *PRESSURES, 'force'):
        if name in recording and np.ptp(recording[name]) == 0.0:
            raise RigError(
                f'{path}: {name} is {recording[name][0]:g} throughout: is it connected? '
                'Omit it, or name it under fixed, if it does not change'
            )
    if system.rig is not None:
        conditioned = apply_conditions(system.rig, dict(recording.conditions))
        check_plausible(path, recording.signals, conditioned)
    _check_span(recording, span, path)


def _check_span(recording: Recording, span: Span, path: Path) -> None:
    """Raise RigError for a signal that is at the end of its sensor's span most of the time."""
    ends = {'position': span.position, **dict.fromkeys(PRESSURES, span.high)}
    at_end = {
        (name, end): recording[name] >= end - 2.0 * recording.noise[name]
        for name, end in ends.items()
        if name in recording
    }
    if 'force' in recording:  # its span is not stated; noise repeats no extreme so often
        force = recording['force']
        at_end |= {('force', end): force == end for end in (force.min(), force.max())}
    for (name, end), flags in at_end.items():
        share = float(np.mean(flags))
        if share > SATURATED:
            raise RigError(
                f"{path}: {name} is at the end of its sensor's span ({end:g}) for "
                f'{share:.0%} of the time; record it within the span'
            )


def _check_gaps(recording: Recording, path: Path) -> None:
    """Raise RigError where so many samples are missing in succession that none can be guessed."""
    interval = recording.interval_ns
    longest_gap = LONGEST_IMPOSED_GAP if 'force' in recording else LONGEST_GAP
    allowed = max(LEAST_GAP, round(1e9 * longest_gap / interval))
    used = {name: at for name, at in recording.missing.items() if name not in ESTIMATED}
    for name, stamps in used.items():
        gaps = np.split(stamps, np.flatnonzero(np.diff(stamps) > interval) + 1)
        longest = max(gaps, key=len)
        if longest.size > allowed:
            first, last = 1e-9 * (longest[[0, -1]] - recording.start_ns)
            raise RigError(
                f'{path}: {longest.size} samples of {name} are missing in succession, from '
                f'{first:.2f} to {last:.2f} s, at most {allowed} allowed; cut the recording there'
            )


def on_bench(recording: Recording) -> bool:
    """Return whether a bench moves the piston and records its force."""
    return 'force' in recording


def lacks(system: System, recording: Recording) -> dict[str, str]:
    """Return balance -> what a file or recording lacks for it, '' where it is open."""
    needs = {
        'gas_1': _of_gas(system, 'cap', 1),
        'gas_2': _of_gas(system, 'rod', 2),
        'force': _of_force(system, on_bench(recording)),
    }
    return {
        balance: ', '.join(need for need in each if not _known(need, system, recording))
        for balance, each in needs.items()
    }


def _of_gas(system: System, side: str, chamber: int) -> Iterator[str]:
    yield f'cylinder.{side}_dead_volume'
    if 'position' not in system.fixed:
        yield f'cylinder.{side}_area'
        if chamber == 2:
            yield 'cylinder.stroke'
    yield from ('gas.supply_temperature', 'gas.heat_capacity_ratio', 'gas.gas_constant')
    if not system.shut:
        yield from ('valve.intake_coefficient', 'valve.exhaust_coefficient')
        yield from ('valve.intake_voltage', 'valve.exhaust_voltage')
        yield from ('operation.supply_pressure', 'signal u')
    yield from ('signal position', f'signal pressure_{chamber}')


def _of_force(system: System, bench: bool) -> Iterator[str]:
    friction = system.hypothesis.model.friction
    yield from ('cylinder.cap_area', 'cylinder.rod_area', 'cylinder.stroke', 'friction.model')
    for keys in FRICTION_KEYS[: friction.model + 1]:
        yield from (f'friction.{key}' for key in keys)
    fades = friction.static_friction_reading == FADES_WHILE_SLIDING
    if friction.model == REVISED_LUGRE_DWELL and fades:
        yield 'friction.memory_time'
    if bench:
        yield from ('signal pressure_1 or pressure_2', 'signal position')
    else:
        yield 'cylinder.moving_mass'
        yield from ('signal position', 'signal pressure_1', 'signal pressure_2')


def _known(need: str, system: System, recording: Recording) -> bool:
    if need == 'signal u':
        return recording.driven
    if need.startswith('signal '):
        names = need.removeprefix('signal ').split(' or ')
        return any(name in recording or name in system.fixed for name in names)
    section, key = need.split('.')
    stated = section == 'operation' and key in recording.conditions
    return stated or key in system.given.get(section, ())
