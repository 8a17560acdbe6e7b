"""Runs of parts of which the truth is known; chambers and friction without the package's model."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from pneu_rig_ros.gap.parts.part import Part
from pneu_rig_ros.gap.parts.prediction import drive
from pneu_rig_ros.gap.parts.recording import Recording, recording
from pneu_rig_ros.model import follow

Floats = NDArray[np.float64]

K, R, WALL = 1.4, 296.8, 290.0
AREAS, DEAD, STROKE = (0.0127, 0.0115), (0.025, 0.044), 2.03
CONDUCTANCES = (12.0, 25.0)
PRESSURE_NOISE, POSITION_NOISE, FORCE_NOISE = 150.0, 1e-4, 0.05
CHAMBERS = """
part: chambers
cylinder: {cap_area: 0.0127 m^2, rod_area: 0.0115 m^2, cap_dead_volume: 0.025 m^3,
           rod_dead_volume: 0.044 m^3, stroke: 2.03 m}
gas: {supply_temperature: 290.0 K, heat_capacity_ratio: 1.4 -, gas_constant: 296.8 J/(kg*K)}
valve: shut
each_recording: [initial_pressure]
refit:
  cylinder.cap_dead_volume: [0.02 m^3, 0.035 m^3]
  cylinder.rod_dead_volume: [0.034 m^3, 0.054 m^3]
"""
FRICTION = """
part: friction
cylinder: {cap_area: 5e-4 m^2, rod_area: 5e-4 m^2, stroke: 0.1 m}
friction: {model: coulomb_viscous, coulomb_force: 6.0 N, element_stiffness: [5e4 N/m]}
each_recording: [force_offset]
"""


def chamber_run(
    name: str, seed: int, fill: tuple[float, float], conductances: tuple[float, float],
    dead: tuple[float, float] = DEAD,
) -> Recording:  # fmt: skip
    """Return two sealed chambers on a piston in waves, by SciPy."""
    time = np.arange(0.0, 120.0, 0.1)
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

    masses = [p * v / (R * WALL) for p, v in zip(fill, volumes(0.0), strict=True)]

    def rate(t: float, pressures: Floats) -> list[float]:
        rows = []
        for i, (p, v) in enumerate(zip(pressures, volumes(t), strict=True)):
            swept = (AREAS[0], -AREAS[1])[i] * speed(t)
            heat = conductances[i] * (WALL - p * float(v) / (masses[i] * R))
            rows.append((-K * p * swept + (K - 1.0) * heat) / float(v))
        return rows

    run = solve_ivp(rate, (0.0, time[-1]), fill, t_eval=time, rtol=1e-8, atol=1.0)
    rng = np.random.default_rng(seed)
    p1, p2 = run.y + rng.normal(0.0, PRESSURE_NOISE, run.y.shape)
    x = position(time) + rng.normal(0.0, POSITION_NOISE, time.size)
    signals = {'position': x, 'pressure_1': p1, 'pressure_2': p2}
    return recording(name, 0.1, signals, 'chambers')


def friction_run(
    name: str, seed: int, gauge: float, slope: float, coulomb: float = 6.0
) -> Recording:
    """Return a seal driven to and fro against a pressure [Pa gauge], by the Dahl law."""
    interval, speed, period = 0.01, 0.01, 6.0
    time = np.arange(0.0, 12.0, interval)
    phase = (time / period) % 1.0
    x = 0.03 + speed * period * np.where(phase < 0.5, phase, 1.0 - phase)
    level, bristle = coulomb + slope * gauge, 0.0
    friction = np.empty(time.size)
    for index, step in enumerate(np.diff(x, prepend=x[0])):
        direction = np.sign(step)
        decay = np.exp(-5e4 / level * abs(step))
        bristle = direction * level + (bristle - direction * level) * decay
        friction[index] = bristle
    rng = np.random.default_rng(seed)
    force = friction + 5e-4 * gauge + 2.0 + rng.normal(0.0, FORCE_NOISE, time.size)
    signals = {
        'position': x, 'pressure_2': np.full(time.size, 1e5 + gauge), 'force': force
    }  # fmt: skip
    return recording(name, interval, signals, 'friction')


def part_file(folder: Path, text: str) -> Path:
    """Return a file with a part's description."""
    path = folder / 'part.yaml'
    path.write_text(text)
    return path


VALVES = """
part: valves
cylinder: {cap_area: 5e-4 m^2, rod_area: 4e-4 m^2, cap_dead_volume: 3e-5 m^3,
           rod_dead_volume: 1e-4 m^3, stroke: 0.3 m}
valve: {intake_coefficient: 4.8e-8 m^2/V, exhaust_coefficient: 1e-6 m^2/V,
        intake_voltage: 2.65 V, exhaust_voltage: 2.35 V}
operation: {supply_pressure: 5e5 Pa}
refit:
  valve.intake_coefficient: [2e-8 m^2/V, 1e-7 m^2/V]
"""


def valve_run(part: Part, name: str, seed: int, effect: str, values: Any) -> Recording:
    """Return valves that fill and empty chambers behind a piston held at 0.1 m, with an effect."""
    interval = 0.005
    time = np.arange(0.0, 24.0, interval)
    u = 0.35 + 0.3 * np.sin(2.0 * np.pi * time / (6.0 + seed))
    blow = (time % 8.0) > 7.0
    signals = {
        'position': np.full(time.size, 0.1), 'u': np.where(blow, -0.4, u),
        'pressure_1': np.full(time.size, 1.5e5), 'pressure_2': np.full(time.size, 2e5),
    }  # fmt: skip
    blank = recording(name, interval, signals, 'valves')
    hypothesis = part.hypothesis.with_effect(effect, values)
    imposed = np.full(time.size - 1, follow.MOTION, dtype=np.int64)
    run = drive(part, hypothesis, blank, np.array([1.5e5, 2e5]), imposed)
    rng = np.random.default_rng(seed)
    for key, pressure in (('pressure_1', run.pressure_1), ('pressure_2', run.pressure_2)):
        clean = np.append(signals[key][0], pressure)
        signals[key] = clean + rng.normal(0.0, PRESSURE_NOISE, time.size)
    return recording(name, interval, signals, 'valves')
