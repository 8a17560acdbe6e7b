"""What is measured on a stroke."""

import itertools
from typing import Any

import numpy as np

from pneu_rig_ros.analysis.motion import find_rests
from pneu_rig_ros.claims.experiments import INTERVAL, Stroke

Floats = np.ndarray[Any, np.dtype[np.float64]]

VISIBLE_CREEP = 0.5e-3
"""
A sticking phase with more travel than this creeps [m].

Seven steps of the position sensor; a bristle of 1e5 N/m bends by 0.2 mm under F_smax.
"""


def middle(values: Floats) -> float:
    """Return the median, NaN of nothing."""
    return float(np.median(values)) if len(values) else np.nan


def dwells(stroke: Stroke) -> Floats:
    """Return the dwell times between slips [s]: all but the rest before the first."""
    return stroke.column('dwell', 1)


def slips(stroke: Stroke) -> Floats:
    """Return the slip lengths [m] but for the first, from rest, and the last, into the end."""
    return stroke.column('slip', 1)[:-1]


def rest_share(stroke: Stroke) -> float:
    """Return the share of the time between the first and the last slip at rest [-]."""
    breakaways = stroke.column('breakaway_time')
    if len(breakaways) < 2:
        return 0.0
    return float(dwells(stroke).sum() / (breakaways[-1] - breakaways[0]))


def rest_share_to_end(stroke: Stroke) -> float:
    """Return the share of the time at rest from the first breakaway to the end [-]."""
    if not stroke.cycles:
        return 0.0
    moving = stroke.run.time[-1] - stroke.cycles[0].breakaway_time
    return float(dwells(stroke).sum() / moving)


def stick_slip_reach(stroke: Stroke) -> float:
    """Return the share of the way covered at which the last slip begins [-]."""
    if not stroke.cycles:
        return 0.0
    last = np.interp(stroke.cycles[-1].breakaway_time, stroke.run.time, stroke.run.position)
    return float((last - stroke.start) / (stroke.run.position[-1] - stroke.start))


def creeping_share(stroke: Stroke) -> float:
    """Return the share of the sticking phases with visible creep [-]."""
    creep = stroke.column('creep')
    return float(np.mean(creep > VISIBLE_CREEP)) if len(creep) else np.nan


def breakaway_samples(stroke: Stroke) -> np.ndarray[Any, np.dtype[np.intp]]:
    """Return the sample of each breakaway, shape (n,)."""
    return np.rint(stroke.column('breakaway_time') / INTERVAL).astype(np.intp)


def pressure_peaks(stroke: Stroke) -> Floats:
    """Return p1 above the atmosphere [Pa] at each breakaway, shape (n,)."""
    atmosphere = stroke.plant.model.gas.atmospheric_pressure
    return np.asarray(stroke.run.pressure_1[breakaway_samples(stroke)] - atmosphere)


def pressure_lows(stroke: Stroke) -> Floats:
    """Return the lowest p1 above the atmosphere [Pa] between breakaways, shape (n - 1,)."""
    begins = breakaway_samples(stroke)
    pressure = stroke.run.pressure_1 - stroke.plant.model.gas.atmospheric_pressure
    return np.array([pressure[a:b].min() for a, b in itertools.pairwise(begins)])


def pressure_drops(stroke: Stroke) -> float:
    """Return the share of slips in which p1 falls by a tenth of what it was above p_atm [-]."""
    lows = pressure_lows(stroke)
    if not len(lows):
        return 0.0
    peaks = pressure_peaks(stroke)[:-1]
    return float(np.mean(peaks - lows > 0.1 * peaks))


def pressure_rise(stroke: Stroke) -> float:
    """Return the median rise of p1 from its lowest value to the next breakaway [Pa]."""
    return middle(pressure_peaks(stroke)[1:] - pressure_lows(stroke))


def gradual(values: Floats) -> float:
    """Return the magnitude of the correlation of values with their number [-], 0 for few."""
    if len(values) < 4 or np.ptp(values) == 0.0:
        return 0.0
    return float(abs(np.corrcoef(np.arange(len(values)), values)[0, 1]))


def largest_flow(stroke: Stroke) -> float:
    """Return the largest flow through a valve [L/min] at 1 bar and 20 degC (ANR, ISO 8778)."""
    density = 1e5 / (stroke.plant.model.gas.gas_constant * 293.15)
    flows = [np.gradient(gas, INTERVAL) for gas in (stroke.run.gas_mass_1, stroke.run.gas_mass_2)]
    return float(np.max(np.abs(flows)) / density * 6e4)


def in_slips(stroke: Stroke) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Return which samples are between a breakaway and the next rest, shape (n,)."""
    where = np.ones(stroke.run.time.size, dtype=bool)
    for rest in find_rests(stroke.run.position, INTERVAL):
        where[rest.first : rest.end] = False
    return where
