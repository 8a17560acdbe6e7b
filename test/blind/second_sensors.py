"""Errors of sensors of the second list, from the literature that ``second`` names."""

from collections.abc import Mapping

import numpy as np

from . import foreign_sensors as first
from .foreign_sensors import POSITION_SPAN

NAMES = 'loaded_potentiometer', 'averaged_position', 'interpolated_position'
"""Forms that are here, see ``second.SECOND``."""


def present(hidden: Mapping[str, float]) -> bool:
    """Whether a form of a sensor, of either list, is among what is hidden."""
    own = any(name.split('.')[0] in NAMES for name in hidden)
    return own or first.present(hidden)


def misread(signals: np.ndarray, interval: float, hidden: Mapping[str, float]) -> np.ndarray:
    """
    Return x [m], p1, p2 [Pa], shape (3, n), as sensors with the hidden forms show them.

    :param interval: between samples [s]
    """
    x, p1, p2 = first.misread(signals, interval, hidden)
    values = {name: hidden.get(f'{name}.strength', 0.0) for name in NAMES}
    share = x / POSITION_SPAN
    x = x / (1.0 + values['loaded_potentiometer'] * share * (1.0 - share))
    period = hidden.get('interpolated_position.period', 1.0)
    x = x + values['interpolated_position'] * np.sin(2.0 * np.pi * x / period)
    return np.stack([_averaged(x, interval, values['averaged_position']), p1, p2])


def _averaged(signal: np.ndarray, interval: float, span: float) -> np.ndarray:
    """Return the mean of the last so many seconds of a signal that is straight between samples."""
    if span == 0.0:
        return signal
    before = int(np.ceil(span / interval)) + 1
    longer = np.concatenate([np.full(before, signal[0]), signal])
    time = interval * np.arange(len(longer))
    sums = np.concatenate([[0.0], np.cumsum(0.5 * interval * (longer[1:] + longer[:-1]))])
    slopes = np.diff(longer, append=longer[-1]) / interval
    start = time[before:] - span
    place = np.minimum((start / interval).astype(int), len(longer) - 2)
    rest = start - time[place]
    until = sums[place] + rest * (longer[place] + 0.5 * rest * slopes[place])
    return (sums[before:] - until) / span
