"""
The experiments on a rig: six bags, the same whatever is hidden in it.

Four are for the fit and two are kept back. Together they hold slow outstrokes that stick and slip,
pauses with the valves shut, faster strokes both ways, both end stops under pressure, five supply
pressures, three loads and six places to start from.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

CAPTION = {'cylinder_1': 0.29, 'cylinder_2': 0.34, 'cylinder_3': 0.32}
"""Command [V] at which the paper shows each cylinder stick and slip."""
LOADS = {
    'cylinder_1': (0.2, 2.0, 5.3),
    'cylinder_2': (0.2, 2.5, 5.3),
    'cylinder_3': (0.2, 3.0, 5.3),
}
"""Loads [kg] called 0, 1, 2 below."""
FAST = {'cylinder_1': 1.0, 'cylinder_2': 1.2, 'cylinder_3': 1.4}
"""A wider cylinder needs more of the valve for the same speed: what tenths of a volt become."""


class Experiment(NamedTuple):
    """One bag: set-up, and (duration [s], command) one after the other."""

    supply_pressure: float
    load: int
    start: float
    """Share of the stroke."""
    rest_time: float
    timeline: tuple[tuple[float, float], ...]
    """Commands from 'slow': the caption's command; one more is 0.1 V more; 0 shuts the valves."""


def out(tenths: float) -> float:
    """Code of an outstroke, tenths of a volt above the caption's command."""
    return 1.0 + tenths


def back(tenths: float) -> float:
    """Code of an instroke."""
    return -1.0 - tenths


PAUSE = 0.0
HOLD = 0.1
"""Every duration below is a multiple of this [s]."""
FIT = (
    Experiment(5e5, 0, 0.0, 1200.0, (  # stick-slip as in the captions
        (0.3, PAUSE), (5.5, out(0)), (1.5, PAUSE), (2.5, out(0.3)), (0.8, PAUSE),
        (3.4, back(0.5)),
    )),
    Experiment(4e5, 1, 0.5, 60.0, (  # from the middle, both ways, a long dwell
        (0.3, PAUSE), (3.0, back(0.5)), (1.0, PAUSE), (3.5, out(0.5)), (3.0, PAUSE),
        (1.2, out(3)), (2.0, back(3)),
    )),
    Experiment(7e5, 2, 0.75, 600.0, (  # onto the outer stop, filled, shut, and back
        (0.3, PAUSE), (1.5, out(0.5)), (0.5, PAUSE), (3.0, out(15)), (3.0, PAUSE),
        (3.0, back(3)), (0.7, PAUSE), (2.0, back(0.5)),
    )),
    Experiment(6e5, 0, 0.15, 1200.0, (  # onto the inner stop, filled, shut, and out again
        (0.3, PAUSE), (1.5, back(1)), (0.8, PAUSE), (3.0, back(15)), (2.5, PAUSE), (3.0, out(4)),
        (0.6, PAUSE), (2.3, out(1)),
    )),
)  # fmt: skip
VERIFY = (
    Experiment(5e5, 1, 0.1, 300.0, (
        (0.3, PAUSE), (4.0, out(0.1)), (2.5, PAUSE), (2.0, out(1)), (1.0, back(2)), (1.0, PAUSE),
        (3.2, back(0.6)),
    )),
    Experiment(6.5e5, 0, 0.6, 900.0, (
        (0.3, PAUSE), (2.0, back(0.8)), (1.2, PAUSE), (2.5, out(20)), (3.0, PAUSE),
        (2.0, back(4)), (0.5, PAUSE), (2.5, out(1)),
    )),
)  # fmt: skip
NAMES = tuple(
    f'{group}_{number}'
    for group, bags in (('fit', FIT), ('verify', VERIFY))
    for number in range(1, len(bags) + 1)
)
"""Of the bags, first those of the fit."""


def levels(experiment: Experiment, cylinder: str) -> list[tuple[float, float]]:
    """Return duration [s] and u [V], one after the other."""
    slow, tenth = CAPTION[cylinder], 0.1 * FAST[cylinder]
    return [
        (duration, float(np.sign(code)) * (slow + tenth * (abs(code) - 1.0)) if code else 0.0)
        for duration, code in experiment.timeline
    ]


def command(experiment: Experiment, cylinder: str, interval: float) -> NDArray[np.float64]:
    """Return u [V] of each sampling interval."""
    pieces = levels(experiment, cylinder)
    return np.concatenate([np.full(round(duration / interval), u) for duration, u in pieces])


def profile(experiment: Experiment, cylinder: str) -> dict[str, object]:
    """Return the command as a profile of the excitation node."""
    held = [
        f'{u!r} V'
        for duration, u in levels(experiment, cylinder)
        for _ in range(round(duration / HOLD))
    ]
    return {'drives': 'u', 'shape': 'staircase', 'levels': held, 'hold': f'{HOLD!r} s'}


def set_up(experiment: Experiment, cylinder: str, stroke: float) -> dict[str, float]:
    """Return the keys of the section ``operation`` that the experiment sets [SI]."""
    return {
        'supply_pressure': experiment.supply_pressure,
        'load_mass': LOADS[cylinder][experiment.load],
        'initial_position': experiment.start * stroke,
        'rest_time': experiment.rest_time,
    }
