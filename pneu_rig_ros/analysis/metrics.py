"""
Error metrics between two runs on one time axis, and the stick-slip events of a run.

Velocity and friction of both runs are estimated by the same filters, so that differences are those
of the runs and not of the filters.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pneu_rig_ros.analysis.friction import ForceBalance, can_estimate, friction_zero_phase
from pneu_rig_ros.analysis.motion import Cycle, cycles_of
from pneu_rig_ros.analysis.velocity import velocity_of
from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import Recording
from pneu_rig_ros.records.recording import SIGNALS, WHOLE

END_SHARE = 0.98
"""A stroke counts as done at this share of the way to the end stop [-]."""

LEAST_SAMPLES = 4
"""Shorter runs have no friction force."""

NOISE_SAMPLES = 8192
"""Samples of white noise from which the noise of derived signals is estimated."""


class SignalGap(NamedTuple):
    """
    Error of a simulated signal against a measured one, simulated minus measured, in ``unit``.

    :param largest: largest absolute difference
    :param noise: standard deviation of the measured signal's noise, None if it is not known
    """

    unit: str
    rmse: float
    largest: float
    bias: float
    noise: float | None

    @property
    def multiple(self) -> float | None:
        """The RMSE in multiples of the noise [-], None where the noise is 0 or not known."""
        return self.rmse / self.noise if self.noise else None

    @property
    def above_noise(self) -> float:
        """The RMSE beyond the noise, 0 if there is none [unit]."""
        return float(np.sqrt(max(self.rmse**2 - (self.noise or 0.0) ** 2, 0.0)))


class AnalysedRun(NamedTuple):
    """
    A recording with the signals and events derived from it.

    :param recording: the run
    :param signals: name of `recording.SIGNALS` -> signal, shape (n,); without friction where the
        rig is not known, or the sampling too slow for its filter
    :param cycles: stick-slip cycles in the order of time
    :param stroke_time: from the start until the piston has gone 98 % of the way to the end stop
        ahead of it [s], None if it does not get there or the stroke is not known
    """

    recording: Recording
    signals: Mapping[str, Floats]
    cycles: Sequence[Cycle]
    stroke_time: float | None


def analyse_run(recording: Recording) -> AnalysedRun:
    """Return a recording with its derived signals; RigError if too short or not of a whole rig."""
    rig = recording.configuration
    signals = derived_signals(
        recording.position,
        recording.pressure_1,
        recording.pressure_2,
        recording.interval,
        ForceBalance.of(rig) if rig else None,
        recording.name,
    )
    stroke = rig.model.cylinder.stroke if rig else None
    cycles = cycles_of(recording, signals.get('friction'))
    reached = stroke_time(recording.position, recording.interval, stroke)
    return AnalysedRun(recording, signals, cycles, reached)


def derived_signals(
    position: Floats,
    pressure_1: Floats,
    pressure_2: Floats,
    interval: float,
    balance: ForceBalance | None,
    name: str = 'run',
) -> dict[str, Floats]:
    """
    Return name of `recording.SIGNALS` -> signal that is compared, shape (n,).

    Without friction where the rig is not known, or the sampling too slow for its filter.

    :param name: what to call the run in an error
    :raises RigError: for fewer than 4 samples
    """
    if position.size < LEAST_SAMPLES:
        raise RigError(f'{name}: {position.size} samples, at least {LEAST_SAMPLES} are needed')
    found = {
        'position': position,
        'velocity': velocity_of(position, interval),
        'pressure_1': pressure_1,
        'pressure_2': pressure_2,
    }
    if balance is not None and can_estimate(interval):
        found['friction'] = friction_zero_phase(
            position, pressure_1, pressure_2, interval, balance
        )
    return found


def compare_signals(
    measured: Mapping[str, Floats],
    simulated: Mapping[str, Floats],
    noise: Mapping[str, float],
) -> dict[str, SignalGap]:
    """
    Return the errors of simulated signals against measured ones, for every signal of both.

    :param measured, simulated: name -> signal at the same instants [SI], shape (n,)
    :param noise: name -> standard deviation of a measured value, where it is known
    """
    gaps = {}
    for name in (name for name in measured if name in simulated):
        difference = simulated[name] - measured[name]
        gaps[name] = SignalGap(
            unit=SIGNALS[name],
            rmse=float(np.sqrt(np.mean(difference**2))),
            largest=float(np.abs(difference).max()),
            bias=float(difference.mean()),
            noise=noise.get(name),
        )
    return gaps


def signal_noise(
    position_noise: float,
    pressure_noise: float,
    interval: float,
    balance: ForceBalance | None = None,
) -> dict[str, float]:
    """
    Return the standard deviation of the noise of each signal that ``derived_signals`` returns.

    The estimators of the derived signals are linear, so they are applied to white sensor noise,
    which is drawn from a fixed seed.

    :param position_noise: standard deviation of a reading [m]
    :param pressure_noise: of a reading [Pa]
    :param interval: sampling interval [s]
    :param balance: constants of Eq. 2; without them there is no friction
    """
    draws = np.random.default_rng(0).standard_normal((3, NOISE_SAMPLES))
    x, p1, p2 = draws * np.array([[position_noise], [pressure_noise], [pressure_noise]])
    still = balance and replace(balance, atmospheric_pressure=0.0)
    signals = derived_signals(x, p1, p2, interval, still)
    inner = slice(NOISE_SAMPLES // 8, -NOISE_SAMPLES // 8)  # ends are padded, not estimated
    found = {name: float(np.std(signal[inner])) for name, signal in signals.items()}
    known = dict(zip(WHOLE, (position_noise, pressure_noise, pressure_noise), strict=True))
    return found | known


def stroke_time(position: Floats, interval: float, stroke: float | None) -> float | None:
    """
    Return when the piston has gone 98 % of the way to the end stop ahead of it [s].

    That is the one further from where the run starts. None if it does not get there, or the
    stroke [m] is not known.
    """
    if stroke is None:
        return None
    outward = position[0] < stroke / 2
    done = position >= END_SHARE * stroke if outward else position <= (1 - END_SHARE) * stroke
    return float(interval * done.argmax()) if done.any() else None
