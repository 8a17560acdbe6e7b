"""Systems that are no whole rig, and recordings of them made without the package's model."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Floats = NDArray[np.float64]

K, R, WALL = 1.4, 296.8, 290.0
AREAS, DEAD, STROKE = (0.0127, 0.0115), (0.025, 0.044), 2.03
CONDUCTANCES = (12.0, 25.0)
PRESSURE_NOISE, POSITION_NOISE, FORCE_NOISE = 150.0, 1e-4, 0.05
CHAMBERS = """
name: chambers
cylinder: {cap_area: 0.0127 m^2, rod_area: 0.0115 m^2, cap_dead_volume: 0.025 m^3,
           rod_dead_volume: 0.044 m^3, stroke: 2.03 m}
gas: {supply_temperature: 290.0 K, heat_capacity_ratio: 1.4 -, gas_constant: 296.8 J/(kg*K)}
valve: shut
refit:
  cylinder.cap_dead_volume: [0.02 m^3, 0.035 m^3]
  cylinder.rod_dead_volume: [0.034 m^3, 0.054 m^3]
"""
BENCH = """
name: seal
cylinder: {cap_area: 5e-4 m^2, rod_area: 5e-4 m^2, stroke: 0.1 m}
friction: {model: coulomb_viscous, coulomb_force: 6.0 N, element_stiffness: [5e4 N/m]}
fixed: {pressure_1: 1e5 Pa}
each_recording: [force_offset]
refit:
  friction.coulomb_force: [0.5 N, 50.0 N]
"""
LEAKING = """
name: leaking_chamber
cylinder: {cap_dead_volume: 1e-3 m^3}
gas: {supply_temperature: 293.15 K, heat_capacity_ratio: 1.4 -, gas_constant: 287.0 J/(kg*K)}
valve: shut
fixed: {position: 0 m}
"""
BLOCK = """
name: block
cylinder: {cap_area: 5e-4 m^2, rod_area: 4e-4 m^2, cap_dead_volume: 3e-5 m^3,
           rod_dead_volume: 1e-4 m^3, stroke: 0.3 m}
gas: {supply_temperature: 293.15 K, heat_capacity_ratio: 1.4 -, gas_constant: 287.0 J/(kg*K)}
valve: {intake_coefficient: 4.8e-8 m^2/V, exhaust_coefficient: 1e-6 m^2/V,
        intake_voltage: 2.65 V, exhaust_voltage: 2.35 V}
operation: {supply_pressure: 5e5 Pa}
fixed: {position: 0.1 m}
"""
UNITS = {'position': 'm', 'pressure_1': 'Pa', 'pressure_2': 'Pa', 'force': 'N', 'u': 'V'}


def system_file(folder: Path, text: str) -> Path:
    """Return a file with the description of a system."""
    path = folder / 'system.yaml'
    path.write_text(text)
    return path


def table(path: Path, interval: float, signals: Mapping[str, Floats]) -> Path:
    """Return a text table of signals."""
    size = next(iter(signals.values())).size
    columns = np.column_stack([np.arange(size) * interval, *signals.values()])
    np.savetxt(path, columns, '%.9g', ',', header=','.join(['time', *signals]), comments='')
    return path


def mapping(path: Path, *signals: str) -> Path:
    """Return the mapping of such a table."""
    lines = [f'{one}: {{column: {one}, unit: {UNITS[one]}}}' for one in signals]
    path.write_text('\n'.join(['time: {column: time, unit: s}', *lines]) + '\n')
    return path


def chamber_run(
    seed: int,
    fill: tuple[float, float],
    conductances: tuple[float, float],
    dead: tuple[float, float] = DEAD,
    duration: float = 120.0,
    power: float = 0.0,
    late: float = 0.0,
    warm: float = 0.0,
) -> dict[str, Floats]:
    """
    Return two sealed chambers on a piston in waves, every 0.1 s, by SciPy.

    :param power: with which of the pressure the heat transfer grows [-], 0.8 by G. Woschni,
        SAE 670931 (1967)
    :param late: delay of the pressures [s]
    :param warm: temperature of the gas at the start less that of the walls [K]
    """
    time = np.arange(0.0, duration, 0.1)
    rates = (2.0 * np.pi / 9.0, 2.0 * np.pi / 31.0)

    def position(t: Floats | float) -> Floats:
        x: Floats = 1.0 + 0.55 * np.sin(rates[0] * np.asarray(t) + seed)
        return x + 0.3 * np.sin(rates[1] * np.asarray(t))

    def speed(t: float) -> float:
        fast = 0.55 * rates[0] * np.cos(rates[0] * t + seed)
        return float(fast + 0.3 * rates[1] * np.cos(rates[1] * t))

    def volumes(t: Floats | float) -> tuple[Floats, Floats]:
        x = position(t)
        return dead[0] + AREAS[0] * x, dead[1] + AREAS[1] * (STROKE - x)

    masses = [p * v / (R * (WALL + warm)) for p, v in zip(fill, volumes(0.0), strict=True)]

    def rate(t: float, pressures: Floats) -> list[float]:
        rows = []
        for i, (p, v) in enumerate(zip(pressures, volumes(t), strict=True)):
            swept = (AREAS[0], -AREAS[1])[i] * speed(t)
            grown = (p / fill[i]) ** power
            heat = grown * conductances[i] * (WALL - p * float(v) / (masses[i] * R))
            rows.append((-K * p * swept + (K - 1.0) * heat) / float(v))
        return rows

    run = solve_ivp(rate, (0.0, time[-1]), fill, t_eval=time, rtol=1e-8, atol=1.0)
    rng = np.random.default_rng(seed)
    p1, p2 = run.y + rng.normal(0.0, PRESSURE_NOISE, run.y.shape)
    x = position(time + late) + rng.normal(0.0, POSITION_NOISE, time.size)
    return {'position': x, 'pressure_1': p1, 'pressure_2': p2}


def vessel_run(
    seed: int, fill: float, warm: float, leak: float, conductance: float, duration: float = 100.0
) -> dict[str, Floats]:
    """
    Return the pressure in the leaking chamber, every 0.1 s, by SciPy: choked flow, Newton cooling.

    :param warm: temperature of the gas at the start less that of the walls [K]
    :param leak: area of the hole [m^2]
    """
    gas_constant, wall, volume = 287.0, 293.15, 1e-3
    speed = np.sqrt(K * gas_constant * wall)
    choked = (2.0 / (K + 1.0)) ** ((K + 1.0) / (2.0 * (K - 1.0))) * leak * speed
    time = np.arange(0.0, duration, 0.1)

    def rate(t: float, state: Floats) -> list[float]:
        pressure, mass = state
        flow = -choked * pressure / (gas_constant * wall)
        heat = conductance * (wall - pressure * volume / (mass * gas_constant))
        energy = K * gas_constant * wall * flow + (K - 1.0) * heat
        return [energy / volume, flow]

    start = [fill, fill * volume / (gas_constant * (wall + warm))]
    run = solve_ivp(rate, (0.0, time[-1]), start, t_eval=time, rtol=1e-9, atol=1e-9)
    rng = np.random.default_rng(seed)
    return {'pressure_1': run.y[0] + rng.normal(0.0, PRESSURE_NOISE, time.size)}


def bench_run(
    seed: int,
    gauge: float,
    slope: float,
    coulomb: float = 6.0,
    way: float = 0.03,
    speed: float = 0.01,
    noise: float = POSITION_NOISE / 10.0,
    wave: float = 0.0,
) -> dict[str, Floats]:
    """
    Return a seal driven to and fro against a pressure [Pa gauge], every 10 ms, by Dahl.

    :param way, speed: of the strokes [m, m/s]
    :param noise: of the position [m]
    :param wave: amplitude by which friction changes along the stroke, in waves of 40 mm [N]
    """
    interval, parts, stroke = 0.01, 20, way / speed
    fine = np.arange(0.0, 12.0, interval / parts)
    phase = (fine / (2.0 * stroke)) % 1.0
    x = 0.03 + 2.0 * way * np.where(phase < 0.5, phase, 1.0 - phase)
    levels, bristle = coulomb + slope * gauge + wave * np.sin(2.0 * np.pi * x / 0.04), 0.0
    friction = np.empty(fine.size)
    for index, (step, level) in enumerate(zip(np.diff(x, prepend=x[0]), levels, strict=True)):
        direction = np.sign(step)
        decay = np.exp(-5e4 / level * abs(step))
        bristle = direction * level + (bristle - direction * level) * decay
        friction[index] = bristle
    x, friction = x[::parts], friction[::parts]
    rng = np.random.default_rng(seed)
    force = friction + 5e-4 * gauge + 2.0 + rng.normal(0.0, FORCE_NOISE, x.size)
    pressure = 1e5 + gauge + rng.normal(0.0, PRESSURE_NOISE, x.size)
    return {'position': x + rng.normal(0.0, noise, x.size), 'pressure_2': pressure, 'force': force}
