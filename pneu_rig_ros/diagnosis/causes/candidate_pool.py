"""The candidates for a system: its own parameters and conditions, and effects that can show."""

from __future__ import annotations

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
    Condition,
    Coordinate,
    Explanation,
)
from pneu_rig_ros.diagnosis.inputs.system import System, quantity_of, value_of
from pneu_rig_ros.diagnosis.measured.hypothesis import POSITION_ZERO, SENSOR_CLOCK
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.balances import SLOW_SAMPLING
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.effect import GAS_BALANCES, READING_BALANCES, Balance, Need
from pneu_rig_ros.model.parameters import (
    FRICTION_MODELS,
    LUGRE,
    REVISED_LUGRE,
    REVISED_LUGRE_DWELL,
    Model,
)
from pneu_rig_ros.model.quantity import Quantity, specifications

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
START_RATIOS = (0.85, 1.18)
"""Ratios of a parameter from which a fit starts [-]."""
START_SHIFTS = (-0.02, 0.02)
"""Shifts of an opening voltage from which a fit starts [V]."""
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
    Return the candidates that may explain a gap in some runs, and what is fitted with any.

    That is the calibration, and what the file names as possibly wrong.

    :param without: effects that are not candidates
    """
    balances = frozenset().union(*(run.balances for run in runs))
    parameters = list(_parameters(system, balances))
    base = Explanation()
    if (gains := calibration(system, balances)) is not None:
        base = base.with_part(gains, gains.starts[0])
    candidates = [*_conditions(system, runs, balances), *_effects(system, runs, balances, without)]
    if not system.refit:
        return [*parameters, *candidates], base
    for candidate in parameters:
        base = base.with_part(candidate, (candidate.model_value,))
    return candidates, base


def calibration(system: System, balances: frozenset[str]) -> Candidate | None:
    """
    Return what is known within its class only, as a candidate; None for a calibrated rig.

    That is the gains of the sensors, and of a fed rig the pressure and temperature of its supply.
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
    coordinates = tuple(
        # a little wider than the class, so that a class of 0 is an interval
        Coordinate(name, quantity, 1.0 - most - 1e-6, 1.0 + most + 1e-6, GAIN_SCALE, False, 1.0)
        for name, most in errors.items()
    )
    return Candidate(CALIBRATION, SENSOR, coordinates, ((1.0,) * len(coordinates),))


def _parameters(system: System, balances: frozenset[str]) -> Iterator[Candidate]:
    """Yield the parameters that may be wrong: those under ``refit``, else the usual ones."""
    model = system.hypothesis.model
    if system.refit:
        for name, (low, high) in system.refit.items():
            yield _refit_parameter(model, name, low, high)
        return
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
    value, quantity = value_of(model, name), quantity_of(name)
    logarithmic = low > 0.0 and quantity.unit != 'V'
    scale = 1.0 if logarithmic else 0.2 * (high - low)
    key = name.split('.')[1]
    coordinate = Coordinate(key, quantity, low, high, scale, logarithmic, value)
    group = FORCE if name.startswith('friction') else GAS
    starts = tuple((value + 0.2 * (end - value),) for end in (low, high))
    return Candidate(name, group, (coordinate,), starts, value)


def _parameter(model: Model, name: str, group: str) -> Candidate:
    """Return a parameter that may be wrong within the usual range."""
    value, quantity, key = value_of(model, name), quantity_of(name), name.split('.')[1]
    if quantity.unit == 'V':
        low, high = quantity.within(value - VOLTAGE_ERROR), quantity.within(value + VOLTAGE_ERROR)
        starts = tuple((value + shift,) for shift in START_SHIFTS)
        coordinate = Coordinate(key, quantity, low, high, 0.1, False, value)
    else:
        low = quantity.within(value / PARAMETER_RATIO)
        high = quantity.within(value * PARAMETER_RATIO)
        if key == 'breakaway_force':
            low = max(low, model.friction.coulomb_force)
        if key == 'coulomb_force':
            high = min(high, max(model.friction.breakaway_force, value))
        starts = tuple((value * ratio,) for ratio in START_RATIOS)
        coordinate = Coordinate(key, quantity, low, high, 1.0, True, value)
    return Candidate(name, group, (coordinate,), starts, value)


def _conditions(
    system: System, runs: Sequence[Run], balances: frozenset[str]
) -> Iterator[Condition]:
    """Yield the conditions that show and may differ from what is stated."""
    if not system.shut and balances & {'gas_1', 'gas_2'}:
        yield _condition('supply_pressure', GAS, SUPPLY_RATIO, SUPPLY_ERROR)
    if 'force' in balances and any(run.operation.load_mass > 0.0 for run in runs):
        yield _condition('load_mass', FORCE, LOAD_RATIO)
    if system.rig is not None:
        quantity = Quantity('m', -ZERO_ERROR, ZERO_ERROR, 'position reading at the inner end')
        yield _difference(POSITION_ZERO, quantity, ZERO_SCALE)
        for low, high in ((-CLOCK_ERROR, -LEAST_CLOCK), (DEAD_TIME, CLOCK_ERROR)):
            quantity = Quantity('s', low, high, 'of the sensors ahead of the commands')
            yield _difference(SENSOR_CLOCK, quantity, CLOCK_SCALE)


def _condition(name: str, group: str, ratio: float, error: float = 0.0) -> Condition:
    quantity = Quantity('-', 1.0 / ratio, ratio, 'times what was stated')
    coordinate = Coordinate('times', quantity, 1.0 / ratio, ratio, 1.0, True, 1.0)
    starts = tuple((ratio**share,) for share in (-0.3, 0.3))
    return Condition(CONDITIONS + name, group, (coordinate,), starts, deviation=error)


def _difference(name: str, quantity: Quantity, scale: float) -> Condition:
    low, high = quantity.low, quantity.high
    coordinate = Coordinate('by', quantity, low, high, scale, False)
    starts = tuple((low + share * (high - low),) for share in (0.1, 0.3, 0.6, 0.9))
    return Condition(CONDITIONS + name, SENSOR, (coordinate,), starts)


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
    law = FRICTION_MODELS[system.hypothesis.model.friction.model]
    excluded = {*system.hypothesis.effects, *without}
    for name in library.names():
        effect = library.load(name)
        fits_law = not effect.laws or law in effect.laws
        if name in excluded or effect.describes or not fits_law:
            continue
        if not set(effect.needs) <= available or not _shows(effect.balance, system, balances):
            continue
        candidate = _of_open_chambers(effect_candidate(name), balances)
        if candidate.coordinates and candidate.starts:
            yield candidate if system.rig is not None else _laddered(candidate)


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


def effect_candidate(name: str) -> Candidate:
    """Return an effect of the library as a candidate."""
    effect = library.load(name)
    coordinates = []
    columns = zip(*effect.probes, strict=True)
    specs = specifications(effect.parameters).items()
    for (key, spec), probes, null in zip(specs, columns, effect.null, strict=True):
        quantity = cast(Quantity, spec)
        logarithmic = quantity.low >= 0.0 and min(probes) > 0.0
        low = max(quantity.low, 1e-3 * min(probes)) if logarithmic else quantity.low
        scale = max(abs(value) for value in probes) or 1.0
        coordinates.append(Coordinate(key, quantity, low, quantity.high, scale, logarithmic, null))
    starts = tuple(tuple(float(value) for value in probe) for probe in effect.probes)
    balance = effect.balance.name.lower().replace('_', ' ')
    return Candidate(name, balance, tuple(coordinates), starts)


def _of_open_chambers(candidate: Candidate, balances: frozenset[str]) -> Candidate:
    """Return a candidate without the coordinates of a chamber whose balance is closed."""
    closed = tuple(f'_{i}' for i in (1, 2) if f'gas_{i}' not in balances)
    if 'force' in balances or len(closed) != 1:  # both pressures drive the force
        return candidate
    keep = [i for i, c in enumerate(candidate.coordinates) if not c.name.endswith(closed)]
    if len(keep) == len(candidate.coordinates):
        return candidate
    starts = {tuple(start[i] for i in keep) for start in candidate.starts}
    return replace(
        candidate,
        coordinates=tuple(candidate.coordinates[i] for i in keep),
        starts=tuple(sorted(start for start in starts if any(start))),
    )


def _laddered(candidate: Candidate) -> Candidate:
    """Return a candidate that starts from multiples of its probes, within its physical range."""
    unit = candidate.coordinates[0].quantity.unit  # that of its strength
    starts, coordinates = [], []
    for probe in candidate.starts:
        for factor in LADDER:
            start = []
            for c, value in zip(candidate.coordinates, probe, strict=True):
                multiple = value * (factor if c.quantity.unit == unit else 1.0)
                start.append(float(np.clip(multiple, c.quantity.low, c.quantity.high)))
            starts.append(tuple(start))
    for c in candidate.coordinates:
        low = min(c.low, max(c.quantity.low, 1e-3 * c.low)) if c.logarithmic else c.quantity.low
        coordinates.append(replace(c, low=low, high=c.quantity.high))
    return replace(candidate, coordinates=tuple(coordinates), starts=tuple(dict.fromkeys(starts)))
