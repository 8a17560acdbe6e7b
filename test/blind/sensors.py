"""
What the data acquisition reads: noise, 12-bit converter, position differentiated to velocity.

Errors of gain are left out, unless asked for: the model of such a rig says how large they may be.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from scipy.signal import bilinear, lfilter

from .plant import Motion
from .second_sensors import misread, present

LEVELS = 4095
SENSOR_ERRORS = (
    'position_scale.error',
    'pressure_offset.offset_1',
    'pressure_offset.offset_2',
    'sensor_delay.time_constant',
)
"""What can be hidden here, effect.parameter."""


CLASSES = (0.005, 0.01, 0.01)
"""Accuracy of the sensors of x, p1, p2, share of full scale (section 2.1 of the paper) [-]."""
CALIBRATED = (1.0, 1.0, 1.0)
"""Slopes of sensors without errors of gain [-]."""
Gains = tuple[float, float, float]


class Readings(NamedTuple):
    """Readings at the sampling instants, shape (n,), SI, absolute pressures."""

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    pressure_1: np.ndarray
    pressure_2: np.ndarray


def read(
    motion: Motion,
    sensors: Mapping[str, float],
    atmosphere: float,
    noise: float,
    seed: int,
    hidden: Mapping[str, float],
    gains: Gains = CALIBRATED,
) -> Readings:
    """
    Return the readings.

    :param sensors: section of the configuration
    :param atmosphere: zero of the pressure sensors [Pa]
    :param noise: multiple of the rig's noise [-]
    :param hidden: effect.parameter -> value; those of the sensors are used
    :param gains: slopes of the sensors of x, p1, p2 [-]
    """
    random = np.random.default_rng(seed)
    random.random(3)  # the answers kept are to this noise, which began after three draws
    zeros = np.array([0.0, atmosphere, atmosphere])
    sizes = np.array([sensors['position_noise'], *[sensors['pressure_noise']] * 2])
    spans = sensors['position_span'], sensors['pressure_span'], sensors['pressure_span']
    true = distorted(motion, hidden)
    signals = np.array(gains)[:, None] * (true - zeros[:, None])
    signals += noise * sizes[:, None] * random.standard_normal(signals.shape)
    x, p1, p2 = (
        zero + _converted(signal, span)
        for zero, signal, span in zip(zeros, signals, spans, strict=True)
    )
    velocity = _differentiated(x, float(motion.time[1]), sensors['velocity_cutoff'])
    return Readings(motion.time, x, velocity, p1, p2)


def drawn_gains(seed: int) -> Gains:
    """Return slopes of the sensors of x, p1, p2 within their accuracy classes [-]."""
    errors = np.array(CLASSES) * np.random.default_rng(seed).uniform(-1.0, 1.0, 3)
    x, p1, p2 = (1.0 + errors).tolist()
    return x, p1, p2


def distorted(motion: Motion, hidden: Mapping[str, float]) -> np.ndarray:
    """Return x [m], p1, p2 [Pa], shape (3, n), as sensors with the hidden errors see them."""
    x, p1, p2 = motion.position, motion.pressure_1, motion.pressure_2
    if lag := hidden.get('sensor_delay.time_constant', 0.0):
        x = lagging(x, float(motion.time[1]), lag)
    x = x * (1.0 + hidden.get('position_scale.error', 0.0))
    p1 = p1 + hidden.get('pressure_offset.offset_1', 0.0)
    p2 = p2 + hidden.get('pressure_offset.offset_2', 0.0)
    signals = np.stack([x, p1, p2])
    return misread(signals, float(motion.time[1]), hidden) if present(hidden) else signals


def lagging(signal: np.ndarray, interval: float, lag: float) -> np.ndarray:
    """First-order lag [s], exact for a signal that is straight between the samples."""
    share = interval / lag
    pole = np.exp(-share)
    b = np.array([1.0 - (1.0 - pole) / share, (1.0 - pole) / share - pole])
    start = [signal[0] * (1.0 - b[0])]
    return lfilter(b, [1.0, -pole], signal, zi=start)[0]


def _converted(signal: np.ndarray, span: float) -> np.ndarray:
    step = span / LEVELS
    return np.round(np.clip(signal, 0.0, span) / step) * step


def _differentiated(position: np.ndarray, interval: float, cutoff: float) -> np.ndarray:
    slope = np.diff(position, prepend=position[0]) / interval
    warped = 2.0 / interval * np.tan(np.pi * cutoff * interval)
    b, a = bilinear([warped], [1.0, warped], fs=1.0 / interval)
    return lfilter(b, a, slope)
