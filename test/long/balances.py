"""
What must hold in every run of the plant, whatever the rig.

Gas: the internal energy U = p V / (k - 1) of a chamber changes by the enthalpy of the gas that
comes in, k R T_s / (k - 1) per kilogram, by the heat Q, and by the work that it does:

    dU = k R T_s / (k - 1) dm + dQ - p dV                                                (Eq. 6)

Motion: from rest, friction has taken up energy at any time, as what its bristles and film have in
store is at least nothing. Both together, with the kinetic energy and the work against the
atmosphere, say that energy is not created:

    dU + d(M v^2 / 2) + p_atm (A1 - A2) dx <= k R T_s / (k - 1) dm + Q

The integrals of p dV and of Q are taken over the samples; p dV as if the change from one sample to
the next were polytropic, p V^n = const, which it is to the first order however violent it is.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.effect import Balance
from pneu_rig_ros.model.parameters import Model
from pneu_rig_ros.model.plant import Trajectory

Floats = NDArray[np.float64]

STOP_TOLERANCE = 1e-9
"""How far beyond an end stop the piston may be [m]."""


STEADY = 1e-6
"""Change of ln p V between samples below which its logarithmic mean is as good as its mean [-]."""

UNBOUNDED = {
    'cross_piston_leak',
    'local_piston_leak',
    'wall_heat_transfer',
    'natural_convection',
    'forced_convection',
    'gas_mass_heat_transfer',
    'line_lag',
}
"""Effects with which a pressure has other ways up than supply and piston."""


class Residuals(NamedTuple):
    """
    How far the balances are from holding, as shares of the energy that was moved [-].

    :param gas: of the chambers, the larger one
    :param created: energy created; negative: lost by friction and impacts
    :param dissipated: smallest energy taken up by friction up to any time; must not be negative
    :param overpressure: largest pressure above supply, atmosphere and start, as a share of what
        compression by the piston allows; at most 1
    """

    gas: float
    created: float
    dissipated: float
    overpressure: float


def problems(run: Trajectory, model: Model) -> list[str]:
    """Return what cannot be: values that are not finite, pressures, positions."""
    found = [name for name, column in run._asdict().items() if not np.isfinite(column).all()]
    if found:
        return [f'{name} is not finite' for name in found]
    stroke = model.cylinder.stroke
    beyond = max(-run.position.min(), run.position.max() - stroke)
    checks = {
        f'a pressure of {min(run.pressure_1.min(), run.pressure_2.min()):.3g} Pa': min(
            run.pressure_1.min(), run.pressure_2.min()
        )
        > 0.0,
        f'{beyond:.3g} m beyond a stop': beyond <= STOP_TOLERANCE,
    }
    return [text for text, holds in checks.items() if not holds]


def residuals(run: Trajectory, start: Any, model: Model, effects: dict[str, Any]) -> Residuals:
    """
    Return the residuals of a run.

    :param start: state before the first sample
    """
    x, v, p1, p2, m1, m2 = (
        np.concatenate([[getattr(start, name)], getattr(run, name)])
        for name in (
            'position',
            'velocity',
            'pressure_1',
            'pressure_2',
            'gas_mass_1',
            'gas_mass_2',
        )
    )
    time = np.concatenate([[0.0], run.time])
    cylinder, gas = model.cylinder, model.gas
    k, ambient = gas.heat_capacity_ratio, gas.atmospheric_pressure
    enthalpy = k / (k - 1.0) * gas.gas_constant * gas.supply_temperature
    chambers = (
        (p1, cylinder.cap_dead_volume + cylinder.cap_area * x, m1),
        (p2, cylinder.rod_dead_volume + cylinder.rod_area * (cylinder.stroke - x), m2),
    )
    heat = _heat(chambers, time, model, effects)
    gas_residual, created, moved = 0.0, np.zeros(x.size), 0.0
    for (p, volume, mass), warmed in zip(chambers, heat, strict=True):
        energy, brought = p * volume / (k - 1.0), enthalpy * (mass - mass[0])
        work = _work(p, volume)
        full = model.operation.supply_pressure * volume.max() / (k - 1.0)
        scale = full + np.abs(brought).max() + np.abs(work).max()
        left = energy - energy[0] - brought - warmed + work
        gas_residual = max(gas_residual, float(np.abs(left).max() / scale))
        created += energy - energy[0] - brought - warmed
        moved += scale
    rod = cylinder.cap_area - cylinder.rod_area
    kinetic = 0.5 * model.total_mass * v**2
    taken = (
        _work(p1, chambers[0][1])
        + _work(p2, chambers[1][1])
        - ambient * rod * (x - x[0])
        - kinetic
    )
    created += kinetic + ambient * rod * (x - x[0])
    if _pushed(effects):
        created, taken = np.zeros(1), np.zeros(1)
    return Residuals(
        gas_residual,
        float(created.max() / moved),
        float(taken.min() / moved),
        max(_overpressure(p, volume, start, model, effects) for p, volume, _ in chambers),
    )


def _work(pressure: Floats, volume: Floats) -> Floats:
    """
    Return the integral of p dV from the first sample on [J], shape (n,).

    Of a polytropic change it is exact: the change of ln V times the logarithmic mean of p V.
    """
    energy = pressure * volume
    rise = np.diff(np.log(energy))
    steady = np.abs(rise) < STEADY
    middle = 0.5 * (energy[1:] + energy[:-1])
    mean = np.where(steady, middle, np.diff(energy) / np.where(steady, 1.0, rise))
    return np.concatenate([[0.0], np.cumsum(np.diff(np.log(volume)) * mean)])


def _integral(values: Floats, over: Floats) -> Floats:
    """Return the integral of values over something, from the first sample on, shape (n,)."""
    parts = 0.5 * (values[1:] + values[:-1]) * np.diff(over)
    return np.concatenate([[0.0], np.cumsum(parts)])


def _pushed(effects: dict[str, Any]) -> bool:
    """Return whether forces act beside those of gas and friction."""
    return any(library.load(name).balance is Balance.FORCE for name in effects)


def _heat(
    chambers: Any, time: Floats, model: Model, effects: dict[str, Any]
) -> tuple[Floats, Floats]:
    """Return the heat that came into each chamber [J], shape (n,), from walls at T_s."""
    cooled = effects.get('wall_heat_transfer', (0.0, 0.0))
    *convected, power = effects.get('natural_convection', (0.0, 0.0, 0.25))
    coefficient, growth = effects.get('forced_convection', (0.0, 0.8))
    (rate,) = effects.get('gas_mass_heat_transfer', (0.0,))
    capacity = rate * model.gas.gas_constant / (model.gas.heat_capacity_ratio - 1.0)
    areas = model.cylinder.cap_area, model.cylinder.rod_area
    rows, flows = zip(cooled, convected, areas, chambers, strict=True), []
    for newton, convection, area, (p, volume, mass) in rows:
        colder = model.gas.supply_temperature - p * volume / (mass * model.gas.gas_constant)
        wall = 2.0 * area + 2.0 * volume * math.sqrt(math.pi / area)
        conductance = newton + convection * (np.abs(colder) / 10.0) ** power
        conductance += coefficient * wall * (p / 3e5) ** growth + capacity * mass
        flows.append(_integral(conductance * colder, time))
    return flows[0], flows[1]


def _overpressure(
    p: Floats, volume: Floats, start: Any, model: Model, effects: dict[str, Any]
) -> float:
    """Return the pressure as a share of what the piston can have compressed it to, adiabatic."""
    operation = model.operation
    highest = max(
        operation.supply_pressure,
        model.gas.atmospheric_pressure,
        start.pressure_1,
        start.pressure_2,
    )
    allowed = highest * (volume.max() / volume) ** model.gas.heat_capacity_ratio
    if UNBOUNDED & set(effects):
        return 0.0
    return float((p / allowed).max())
