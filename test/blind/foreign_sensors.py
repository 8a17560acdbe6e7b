"""Foreign errors of sensors, from the literature that ``foreign`` names; zero strength is none."""

from collections.abc import Mapping

import numpy as np
from scipy.signal import bilinear, lfilter

RUN = 14.0
"""In which a drift reaches its strength [s], about one recording."""
POSITION_SPAN, PRESSURE_SPAN, ATMOSPHERE = 0.3, 1e6, 1e5
"""Of the sensors [m, Pa], and the zero of the pressures [Pa]."""
NAMES = (
    'bowed_position',
    'drifting_position',
    'position_play',
    'two_pole_position_lag',
    'drifting_pressure_zero',
    'warming_pressure_zero',
    'bowed_pressure',
    'slow_pressure_sensor',
)
"""Forms that are here, see ``foreign.FORMS``."""


def present(hidden: Mapping[str, float]) -> bool:
    """Whether one of these forms is among what is hidden, form.number -> value."""
    return any(name.split('.')[0] in NAMES for name in hidden)


def misread(signals: np.ndarray, interval: float, hidden: Mapping[str, float]) -> np.ndarray:
    """
    Return x [m], p1, p2 [Pa], shape (3, n), as sensors with the hidden forms show them.

    :param interval: between samples [s]
    """
    x, p1, p2 = signals.copy()
    time = interval * np.arange(len(x))
    values = {name: hidden.get(f'{name}.strength', 0.0) for name in NAMES}
    if lag := values['two_pole_position_lag']:  # damping 0.7
        x = _filtered(x, [lag**2, 1.4 * lag, 1.0], interval)
    x = _played(x, values['position_play'])
    x = x + values['bowed_position'] * _bow(x / POSITION_SPAN)
    x = x + values['drifting_position'] * time / RUN
    if lag := values['slow_pressure_sensor']:
        p1, p2 = (_filtered(pressure, [lag, 1.0], interval) for pressure in (p1, p2))
    warm = hidden.get('warming_pressure_zero.time', 1.0)
    zero = values['warming_pressure_zero'] * (1.0 - np.exp(-time / warm))
    drift = values['drifting_pressure_zero'] * time / RUN
    p1, p2 = (
        pressure + values['bowed_pressure'] * _bow((pressure - ATMOSPHERE) / PRESSURE_SPAN)
        for pressure in (p1, p2)
    )
    return np.stack([x, p1 + drift, p2 + zero])


def _bow(share: np.ndarray) -> np.ndarray:
    """Return the deviation of a sensor that is right at both ends of its span (IEC 61298-2)."""
    return 4.0 * share * (1.0 - share)


def _played(x: np.ndarray, width: float) -> np.ndarray:
    """Return where the slider of a potentiometer is that has play in its coupling [m]."""
    if width == 0.0:
        return x
    found, now = np.empty_like(x), x[0]
    for k, wanted in enumerate(x):
        now = min(max(now, wanted - 0.5 * width), wanted + 0.5 * width)
        found[k] = now
    return found


def _filtered(signal: np.ndarray, below: list[float], interval: float) -> np.ndarray:
    """Return a signal behind a filter 1 / (below) in s, from the highest power on."""
    b, a = bilinear([1.0], below, fs=1.0 / interval)
    return signal[0] + lfilter(b, a, signal - signal[0])
