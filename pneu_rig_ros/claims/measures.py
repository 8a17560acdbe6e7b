"""What is measured on a stroke."""

from typing import Any

import numpy as np

from pneu_rig_ros.claims.experiments import Stroke


def middle(values: np.ndarray[Any, Any]) -> float:
    """Return the median, NaN of nothing."""
    return float(np.median(values)) if len(values) else np.nan


def dwells(stroke: Stroke) -> np.ndarray[Any, Any]:
    """Return the dwell times between slips [s]: all but the rest before the first."""
    return stroke.column('dwell', 1)


def slips(stroke: Stroke) -> np.ndarray[Any, Any]:
    """Return the slip lengths [m] but for the first, from rest, and the last, into the end."""
    return stroke.column('slip', 1)[:-1]


def pressure_drops(stroke: Stroke) -> float:
    """Return the share of slips in which p1 falls by a tenth of its rise before [-]."""
    pressure, time = stroke.run.pressure_1, stroke.run.time
    begins = np.searchsorted(time, stroke.column('breakaway_time'))
    if len(begins) < 2:
        return 0.0
    spans = zip(begins, [*begins[1:], len(time)], strict=True)
    lows = np.array([pressure[a:b].min() for a, b in spans])
    rise = pressure[begins] - stroke.plant.model.operation.initial_pressure_1
    return float(np.mean(pressure[begins] - lows > 0.1 * rise))


def creep_while_sticking(stroke: Stroke) -> float:
    """Return the median way from the end of a slip to the next breakaway [m]."""
    time, position = stroke.run.time, stroke.run.position
    starts = stroke.column('breakaway_time', 1)
    rests = starts - dwells(stroke)
    ways = np.interp(starts, time, position) - np.interp(rests, time, position)
    return middle(ways)


def stuck_share(stroke: Stroke) -> float:
    """Return the share of the time after the first breakaway spent in dwells [-]."""
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
