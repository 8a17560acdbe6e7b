"""
What may be other than stated around a rig: its supply, load and start, its records, its file.

The nuisances of a laboratory (stamps that jitter, samples that are lost, wear from bag to bag) are
here too. Gains of sensors and the temperature of the air are not: see ``sensors``, ``settings``.
"""

from typing import Any, NamedTuple

import numpy as np

from .sensors import Readings
from .settings import Settings

PSI_BY_BAR = 6894.757 / 1e5
"""What one psi is in bar."""


class Circumstances(NamedTuple):
    """
    How things are, against what is stated; by default as stated.

    :param supply, load: true over stated [-]
    :param start: zero of the position sensor [m]
    :param exchanged: the pressure sensors are plugged into each other's place
    :param model_of: cylinder whose file is given, '' for the right one
    :param unit: factor on the gauge pressures that are recorded [-]
    :param clock: by which the sensors' clock is ahead of the commands' [s]
    :param jitter: standard deviation of the stamps, share of the interval [-]
    :param lost: share of the samples that is lost [-]
    :param wear: by which friction grows from bag to bag [-]
    """

    supply: float = 1.0
    load: float = 1.0
    start: float = 0.0
    exchanged: bool = False
    model_of: str = ''
    unit: float = 1.0
    clock: float = 0.0
    jitter: float = 0.0
    lost: float = 0.0
    wear: float = 0.0


AS_STATED = Circumstances()
WRONG = {
    'supply_pressure': 'gas',
    'load_mass': 'force',
    'position_zero': 'sensor',
    'exchanged_chambers': 'sensor',
    'cylinder': 'gas',
    'pressure_unit': 'sensor',
    'clock_offset': 'sensor',
}
"""Condition that may be wrong -> balance on which it shows; as the answer is to name it."""


def drawn_wrong(name: str, cylinder: str, random: np.random.Generator) -> Circumstances:
    """Return circumstances in which one condition of ``WRONG`` is not as stated."""
    sign = float(random.choice([-1.0, 1.0]))
    others = [f'cylinder_{i}' for i in (1, 2, 3) if f'cylinder_{i}' != cylinder]
    changes: dict[str, dict[str, Any]] = {
        'supply_pressure': {'supply': 1.0 + sign * float(random.uniform(0.025, 0.05))},
        'load_mass': {'load': 1.0 + sign * float(random.uniform(0.08, 0.2))},
        'position_zero': {'start': float(random.uniform(0.0015, 0.004))},
        'exchanged_chambers': {'exchanged': True},
        'cylinder': {'model_of': str(random.choice(others))},
        'pressure_unit': {'unit': PSI_BY_BAR},
        'clock_offset': {'clock': sign * float(random.uniform(0.03, 0.2))},
    }
    return AS_STATED._replace(**changes[name])


def as_it_is(stated: Settings, circumstances: Circumstances, number: int) -> Settings:
    """
    Return the settings of the true rig in a recording.

    :param stated: with the conditions as stated
    :param number: of the bag, for what wears
    """
    operation, friction = dict(stated['operation']), dict(stated['friction'])
    operation['supply_pressure'] *= circumstances.supply
    operation['load_mass'] *= circumstances.load
    for level in ('breakaway_force', 'coulomb_force'):
        friction[level] *= 1.0 + circumstances.wear * number
    return {**stated, 'operation': operation, 'friction': friction}


def shown(signals: np.ndarray, circumstances: Circumstances, atmosphere: float) -> np.ndarray:
    """Return x [m], p1, p2 [Pa], shape (3, n), as they come to the record."""
    x, *pressures = signals
    if circumstances.exchanged:
        pressures = pressures[::-1]
    p1, p2 = (atmosphere + circumstances.unit * (p - atmosphere) for p in pressures)
    return np.stack([x + circumstances.start, p1, p2])


def recorded(readings: Readings, circumstances: Circumstances, atmosphere: float) -> Readings:
    """Return readings as they come to the record."""
    signals = np.stack([readings.position, readings.pressure_1, readings.pressure_2])
    x, p1, p2 = shown(signals, circumstances, atmosphere)
    return readings._replace(position=x, pressure_1=p1, pressure_2=p2)


class Stamps(NamedTuple):
    """Stamps of the samples [ns], and which of them are kept, shape (n,)."""

    times: np.ndarray
    kept: np.ndarray


def stamps(count: int, interval_ns: int, circumstances: Circumstances, seed: int) -> Stamps | None:
    """Return the stamps of a recording, None where they are exact."""
    if not (circumstances.jitter or circumstances.lost or circumstances.clock):
        return None
    random = np.random.default_rng([seed, 7])
    moved = circumstances.jitter * random.standard_normal(count)
    times = interval_ns * (np.arange(count) + np.clip(moved, -0.45, 0.45))
    kept = random.random(count) >= circumstances.lost
    kept[[0, -1]] = True
    early = min(circumstances.clock, 0.0)  # of which the commands are stamped the later
    offset = circumstances.clock - early
    # a bag has no time before its first
    return Stamps(np.maximum(np.round(times + 1e9 * offset), 0.0).astype(np.int64), kept)


def command_delay(circumstances: Circumstances) -> int:
    """Return by how much the commands are stamped later [ns], their clock being ahead."""
    return round(1e9 * max(-circumstances.clock, 0.0))
