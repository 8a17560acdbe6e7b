"""The candidates for a system: its own parameters and conditions, and effects that can show."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import cast

import numpy as np

from pneu_rig_ros.diagnosis.causes.candidates import (
    CALIBRATION,
    CONDITIONS,
    FORCE,
    GAS,
    PARAMETER_RATIO,
    SENSOR,
    Candidate,
    Coordinate,
    Explanation,
    effect_candidate,
    of_one,
)
from pneu_rig_ros.diagnosis.inputs.system import QUANTITIES, System, value_of
from pneu_rig_ros.diagnosis.measured.hypothesis import POSITION_ZERO, SENSOR_CLOCK
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.balances import SLOW_SAMPLING
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.effect import GAS_BALANCES, READING_BALANCES, Balance, Effect, Need
from pneu_rig_ros.model.parameters import (
    FRICTION_MODELS,
    LUGRE,
    REVISED_LUGRE,
    REVISED_LUGRE_DWELL,
    Friction,
    Model,
)
from pneu_rig_ros.model.quantity import Choice, Quantity, specifications

GAS_PARAMETERS = (
    'valve.intake_coefficient',
    'valve.exhaust_coefficient',
    'valve.intake_voltage',
    'valve.exhaust_voltage',
    'cylinder.cap_dead_volume',
    'cylinder.rod_dead_volume',
)
"""Parameters that are identified from the pressures under the measured motion."""
FORCE_PARAMETERS = {
    'friction.breakaway_force': LUGRE,
    'friction.coulomb_force': 0,
    'friction.stribeck_velocity': LUGRE,
    'friction.viscous_coefficient': 0,
    'friction.element_stiffness': 0,
    'friction.film_velocity': REVISED_LUGRE,
    'friction.film_time_acceleration': REVISED_LUGRE,
    'friction.film_time_deceleration': REVISED_LUGRE,
    'friction.film_time_dwell': REVISED_LUGRE,
    'friction.dwell_coefficient': REVISED_LUGRE_DWELL,
    'friction.dwell_exponent': REVISED_LUGRE_DWELL,
    'cylinder.moving_mass': 0,
}
"""Parameters that are identified from the motion -> the first friction law that has them."""
CHAMBER_OF = {'cylinder.cap_dead_volume': 'gas_1', 'cylinder.rod_dead_volume': 'gas_2'}
"""Parameter -> the only balance that shows it."""
VOLTAGE_ERROR = 0.15
"""Largest error of a valve's opening voltage [V]."""
START_RATIOS, START_SHIFTS = (0.85, 1.18), (-0.02, 0.02)
"""From which a fit of a parameter [-], or of an opening voltage [V], starts."""
GAIN_SCALE = 0.05
"""Internal unit of a gain [-]."""
SUPPLY_RATIO, LOAD_RATIO = 1.1, 1.5
"""Largest ratios of true to stated supply pressure (a gauge) and load (a guess) [-]."""
SUPPLY_ERROR = 0.03
"""Usual relative error of a stated supply pressure [-]: a gauge of class 1.6 at half its span."""
TEMPERATURE_ERROR = 10.0 / 293.15
"""Usual relative error of an air temperature that was not measured [-]: 10 K."""
ZERO_ERROR, ZERO_SCALE = 0.02, 1e-3
"""Largest error of the zero of the position, unit of its fit [m]."""
LEAST_CLOCK, CLOCK_ERROR, CLOCK_SCALE = 2e-3, 0.5, 0.02
"""Least and largest difference of the clocks, unit of its fit [s]."""
DEAD_TIME = 0.03
"""Commands that act later by less may be a valve's switching time (ISO 12238) [s]."""
LADDER = (0.01, 0.1, 1.0, 10.0, 100.0)
"""Multiples of an effect's probes from which a fit starts for a system of any size [-]."""


def pool(
    system: System, runs: Sequence[Run], without: Sequence[str] = ()
) -> tuple[list[Candidate], Explanation]:
    """
    Return the candidates, but for effects ``without``, and what is fitted with any of them.

    The latter is the calibration, and what the file names as possibly wrong.
    """
    balances = frozenset().union(*(run.balances for run in runs))
    base = Explanation(system.hypothesis)
    if (gains := calibration(system, balances)) is not None:
        base = base.with_part(gains, gains.starts[0])
    candidates = [*_conditions(system, runs, balances), *_effects(system, runs, balances, without)]
    if not system.refit:
        return [*_usual_parameters(system, balances), *candidates], base
    for name, (low, high) in sorted(system.refit.items()):  # the answer has no order of keys
        parameter = _refit_parameter(system.hypothesis.model, name, low, high)
        base = base.with_part(parameter, (parameter.model_value,))
    return candidates, base


def calibration(system: System, balances: frozenset[str]) -> Candidate | None:
    """
    Return what is known within its class only, as a candidate; None for a calibrated rig.

    That is the gains of the sensors, and of a fed rig the pressure and temperature of its supply.
    The zeros of the pressures are set before an experiment, and known to a step of the converter.
    """
    sensors = system.sensors
    if sensors is None or not system.uncalibrated:
        return None
    errors = {
        'position': sensors.position_class,
        'pressure_1': sensors.pressure_class,
        'pressure_2': sensors.pressure_class,
    }
    if system.rig is not None and balances & {'gas_1', 'gas_2'}:
        errors |= {'supply_pressure': SUPPLY_ERROR, 'supply_temperature': TEMPERATURE_ERROR}
    quantity = Quantity('-', 0.0, 2.0, 'true over stated, or gain of a sensor')
    ratios = [_within(name, quantity, most + 1e-6) for name, most in errors.items()]
    step = sensors.pressure_span / 2.0**sensors.resolution
    coordinates = (*ratios, _zero('offset_1', step), _zero('offset_2', step))
    return Candidate(CALIBRATION, SENSOR, coordinates, (tuple(each.null for each in coordinates),))


def _within(name: str, quantity: Quantity, most: float) -> Coordinate:
    """Return a ratio that is off by so much at most, with the variance of any within that."""
    deviation = most / np.sqrt(3.0) / GAIN_SCALE
    return Coordinate(
        name, quantity, 1.0 - most, 1.0 + most, GAIN_SCALE, False, 1.0, float(deviation)
    )


def _zero(name: str, most: float) -> Coordinate:
    """Return an offset of so much at most [Pa], with the variance of any within that."""
    quantity = Quantity('Pa', -most, most, 'what a pressure sensor reads too much')
    return Coordinate(name, quantity, -most, most, most, False, 0.0, 1.0 / np.sqrt(3.0))


def _usual_parameters(system: System, balances: frozenset[str]) -> Iterator[Candidate]:
    """Yield the parameters that may be wrong where the file names none."""
    model = system.hypothesis.model
    names = dict.fromkeys(GAS_PARAMETERS, GAS)
    law = model.friction.model
    names |= {name: FORCE for name, first in FORCE_PARAMETERS.items() if law >= first}
    groups = {FORCE if balance == 'force' else GAS for balance in balances}
    for name, group in names.items():
        section, key = name.split('.')
        given = key in system.given.get(section, ())
        shows = group in groups and CHAMBER_OF.get(name, '') in {'', *balances}
        # of sealed gas in a constant volume only what it gains for each volume shows
        constant = key.endswith('dead_volume') and system.constant_volume
        if given and shows and not (constant or (section == 'valve' and system.shut)):
            candidate = _parameter(model, name, group)
            coordinate = candidate.coordinates[0]
            if coordinate.low < coordinate.high:  # no factor changes a parameter that is zero
                yield candidate


def _refit_parameter(model: Model, name: str, low: float, high: float) -> Candidate:
    """Return a parameter that may be wrong within a range [SI]."""
    value, quantity = value_of(model, name), QUANTITIES[name]
    logarithmic = low > 0.0 and quantity.unit != 'V'
    scale = 1.0 if logarithmic else 0.2 * (high - low)
    coordinate = Coordinate(name.split('.')[1], quantity, low, high, scale, logarithmic, value)
    starts = [value + 0.2 * (end - value) for end in (low, high)]
    group = FORCE if name in FORCE_PARAMETERS or name.startswith('friction') else GAS
    return of_one(name, group, coordinate, starts, value)


def _parameter(model: Model, name: str, group: str) -> Candidate:
    """Return a parameter that may be wrong within the usual range."""
    value, quantity, key = value_of(model, name), QUANTITIES[name], name.split('.')[1]
    if quantity.unit == 'V':
        low, high = value - VOLTAGE_ERROR, value + VOLTAGE_ERROR
        starts = [value + shift for shift in START_SHIFTS]
        scale, logarithmic = 0.1, False
    else:
        low, high = value / PARAMETER_RATIO, value * PARAMETER_RATIO
        starts = [value * ratio for ratio in START_RATIOS]
        scale, logarithmic = 1.0, True
    low, high = quantity.within(low), quantity.within(high)
    if key == 'breakaway_force':
        low = max(low, model.friction.coulomb_force)
    if key == 'coulomb_force':
        high = min(high, max(model.friction.breakaway_force, value))
    coordinate = Coordinate(key, quantity, low, high, scale, logarithmic, value)
    return of_one(name, group, coordinate, starts, value)


def _conditions(
    system: System, runs: Sequence[Run], balances: frozenset[str]
) -> Iterator[Candidate]:
    """Yield the conditions that show and may differ from what is stated."""
    if not system.shut and balances & {'gas_1', 'gas_2'}:
        yield _ratio('supply_pressure', GAS, SUPPLY_RATIO, SUPPLY_ERROR)
    if 'force' in balances and any(run.operation.load_mass > 0.0 for run in runs):
        yield _ratio('load_mass', FORCE, LOAD_RATIO)
    if system.rig is not None:
        quantity = Quantity('m', -ZERO_ERROR, ZERO_ERROR, 'position reading at the inner end')
        yield _difference(POSITION_ZERO, quantity, ZERO_SCALE)
        for low, high in ((-CLOCK_ERROR, -LEAST_CLOCK), (DEAD_TIME, CLOCK_ERROR)):
            quantity = Quantity('s', low, high, 'of the sensors ahead of the commands')
            yield _difference(SENSOR_CLOCK, quantity, CLOCK_SCALE)


def _ratio(name: str, group: str, most: float, deviation: float = 0.0) -> Candidate:
    """Return a condition that differs by a ratio from what is stated."""
    quantity = Quantity('-', 1.0 / most, most, 'times what was stated')
    coordinate = Coordinate('times', quantity, 1.0 / most, most, 1.0, True, 1.0, deviation)
    return of_one(CONDITIONS + name, group, coordinate, (most**share for share in (-0.3, 0.3)))


def _difference(name: str, quantity: Quantity, scale: float) -> Candidate:
    """Return a condition that differs by a number from what is stated."""
    low, high = quantity.low, quantity.high
    coordinate = Coordinate('by', quantity, low, high, scale, False)
    starts = (low + share * (high - low) for share in (0.1, 0.3, 0.6, 0.9))
    return of_one(CONDITIONS + name, SENSOR, coordinate, starts)


def _effects(
    system: System, runs: Sequence[Run], balances: frozenset[str], without: Sequence[str]
) -> Iterator[Candidate]:
    """Yield the effects that the system lacks and can show."""
    available = set() if system.shut else {Need.VALVES}
    if {'gas_1', 'gas_2'} <= balances:
        available.add(Need.BOTH_CHAMBERS)
    if 'force' in balances and all(run.force is None for run in runs):
        available.add(Need.FREE_MOTION)
    if all(run.interval <= SLOW_SAMPLING for run in runs):
        available.add(Need.MILLISECONDS)
    friction = FRICTION_MODELS[system.hypothesis.model.friction.model]
    excluded = {*system.hypothesis.effects, *without}
    for name in library.names():
        effect = library.load(name)
        fits_law = not effect.laws or friction in effect.laws
        if name in excluded or effect.describes or not fits_law:
            continue
        if not set(effect.needs) <= available or not _shows(effect.balance, system, balances):
            continue
        candidate = _of_open_chambers(effect_candidate(name), balances)
        for law in _laws(candidate, effect):
            scaled = law if system.rig is not None else _laddered(law)
            yield from (replace(scaled, readings=each) for each in _readings(effect))


def _laws(candidate: Candidate, effect: Effect) -> Iterator[Candidate]:
    """
    Yield the law of an effect, and the simpler one with the defaults of parameters that have any.

    Data that do not determine an exponent would let it drift to where nothing else fits.
    """
    defaults = effect.parameters._field_defaults
    named = [coordinate.name for coordinate in candidate.coordinates]

    def usual(start: Sequence[float]) -> bool:
        pairs = zip(named, start, strict=True)
        return all(value == defaults.get(name, value) for name, value in pairs)

    general = replace(candidate, starts=tuple(filter(usual, candidate.starts)))
    simpler = general.keeping([i for i, name in enumerate(named) if name not in defaults])
    for law in dict.fromkeys((simpler, candidate)):
        if law.coordinates and law.starts:
            yield law


def _readings(effect: Effect) -> Iterator[tuple[tuple[str, int], ...]]:
    """Yield each combination of the choices that matter with an effect, an empty one of none."""
    choices = [cast(Choice, specifications(Friction)[name]) for name in effect.readings]
    for values in itertools.product(*(range(len(choice.names)) for choice in choices)):
        yield tuple(zip(effect.readings, values, strict=True))


def _shows(balance: Balance, system: System, balances: frozenset[str]) -> bool:
    """Return whether an effect on a balance can show in the open ones."""
    gas = balances != {'force'}
    if balance in (Balance.SPOOL, Balance.SUPPLY):
        return gas and not system.shut
    if balance is Balance.MOTION_READING:
        return 'position' not in system.fixed
    if balance in GAS_BALANCES or balance in READING_BALANCES:
        return gas
    return 'force' in balances


def _of_open_chambers(candidate: Candidate, balances: frozenset[str]) -> Candidate:
    """Return a candidate without the coordinates of a chamber whose balance is closed."""
    closed = tuple(f'_{i}' for i in (1, 2) if f'gas_{i}' not in balances)
    if 'force' in balances or len(closed) != 1:  # both pressures drive the force
        return candidate
    keep = [i for i, c in enumerate(candidate.coordinates) if not c.name.endswith(closed)]
    if len(keep) == len(candidate.coordinates):
        return candidate
    part = candidate.keeping(keep)
    return replace(part, starts=tuple(sorted(filter(any, part.starts))))


def _laddered(candidate: Candidate) -> Candidate:
    """Return a candidate that starts from multiples of its probes, within its physical range."""
    strengths = candidate.strengths
    starts = [
        tuple(
            c.quantity.within(value * factor if c in strengths else value)
            for c, value in zip(candidate.coordinates, probe, strict=True)
        )
        for probe in candidate.starts
        for factor in LADDER
    ]
    coordinates = tuple(
        replace(c, low=max(c.quantity.low, 1e-3 * c.low)) if c.logarithmic else c
        for c in candidate.coordinates
    )
    return replace(candidate, coordinates=coordinates, starts=tuple(dict.fromkeys(starts)))
