"""
The experiments on a rig: six bags, the same for every hidden effect.

Four are for the fit and two are kept back. Together they hold slow outstrokes that stick and slip,
pauses with the valves shut, faster strokes both ways, both end stops under pressure, five supply
pressures, three loads and six places to start from.
"""

from typing import NamedTuple

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
    """
    One bag: set-up and commands.

    :param supply_pressure: [Pa]
    :param load: which of the cylinder's ``LOADS``
    :param start: share of the stroke [-]
    :param rest_time: [s]
    :param words: commands one after the other, such as ``pause 0.3, out+0.5 3.0, back 2.0``;
        `out` and `back` command the caption's voltage, `+x` is x tenths of a volt more, a pause
        shuts the valves; then the duration [s], a multiple of ``HOLD``
    """

    supply_pressure: float
    load: int
    start: float
    rest_time: float
    words: str


HOLD = 0.1
"""Every duration is a multiple of this [s]."""

FIT = (
    # stick-slip as in the captions
    Experiment(
        supply_pressure=5e5,
        load=0,
        start=0.0,
        rest_time=1200.0,
        words='pause 0.3, out 5.5, pause 1.5, out+0.3 2.5, pause 0.8, back+0.5 3.4',
    ),
    # from the middle, both ways, a long dwell
    Experiment(
        supply_pressure=4e5,
        load=1,
        start=0.5,
        rest_time=60.0,
        words='pause 0.3, back+0.5 3.0, pause 1.0, out+0.5 3.5, pause 3.0, out+3 1.2, back+3 2.0',
    ),
    # onto the outer stop, filled, shut, and back
    Experiment(
        supply_pressure=7e5,
        load=2,
        start=0.75,
        rest_time=600.0,
        words=(
            'pause 0.3, out+0.5 1.5, pause 0.5, out+15 3.0, pause 3.0, back+3 3.0, '
            'pause 0.7, back+0.5 2.0'
        ),
    ),
    # onto the inner stop, filled, shut, and out again
    Experiment(
        supply_pressure=6e5,
        load=0,
        start=0.15,
        rest_time=1200.0,
        words=(
            'pause 0.3, back+1 1.5, pause 0.8, back+15 3.0, pause 2.5, out+4 3.0, '
            'pause 0.6, out+1 2.3'
        ),
    ),
)
VERIFY = (
    Experiment(
        supply_pressure=5e5,
        load=1,
        start=0.1,
        rest_time=300.0,
        words='pause 0.3, out+0.1 4.0, pause 2.5, out+1 2.0, back+2 1.0, pause 1.0, back+0.6 3.2',
    ),
    Experiment(
        supply_pressure=6.5e5,
        load=0,
        start=0.6,
        rest_time=900.0,
        words=(
            'pause 0.3, back+0.8 2.0, pause 1.2, out+20 2.5, pause 3.0, back+4 2.0, '
            'pause 0.5, out+1 2.5'
        ),
    ),
)
NAMES = tuple(
    f'{group}_{number}'
    for group, bags in (('fit', FIT), ('verify', VERIFY))
    for number in range(1, len(bags) + 1)
)
"""Of the bags, first those of the fit."""


def levels(experiment: Experiment, cylinder: str) -> list[tuple[float, float]]:
    """Return duration [s] and u [V], one after the other."""
    pieces = []
    for word, duration in (piece.split() for piece in experiment.words.split(',')):
        direction, _, tenths = word.partition('+')
        sign = {'pause': 0.0, 'out': 1.0, 'back': -1.0}[direction]
        step = 1.0 + float(tenths or 0.0)
        u = sign * (CAPTION[cylinder] + 0.1 * FAST[cylinder] * (step - 1.0))
        pieces.append((float(duration), u))
    return pieces


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
