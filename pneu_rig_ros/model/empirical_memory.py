"""
Empirical terms with a wavelength, or with a memory: signals behind a lag, as hidden states.

They describe what no physical effect explains, and are not causes themselves. Every lag is of
first order, and every state zero at the start.
"""

import math
from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.empirical import PRESSURE, SPEED, gauge
from pneu_rig_ros.model.empirical_effects import SOURCE
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE

LAG = Quantity('s', 5e-3, 30.0, 'time constant')
LARGEST_ERROR = 3.0
"""Of a spool [V]."""


class ForceWave(NamedTuple):
    """Amplitudes and wavelength of a force: of a detent, a thread, cogging."""

    sine: Annotated[float, Quantity('N', -1e3, 1e3, 'force, times sin(2 pi x / wavelength)')]
    cosine: Annotated[float, Quantity('N', -1e3, 1e3, 'force, times cos(2 pi x / wavelength)')]
    wavelength: Annotated[float, Quantity('m', 1e-3, 2.0, 'way from one crest to the next')]


@Effect(
    title='a force periodic in the position, without a known cause',
    balance=Balance.FORCE,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source=SOURCE,
    null=ForceWave(0.0, 0.0, 0.02),
    probes=((0.5, 0.5, 0.02), (0.5, 0.5, 0.05)),
    describes=True,
)
def force_wave(signals: Signals, model: CompiledModel, parameters: ForceWave) -> Pair:
    """Return the force along the outstroke [N] and no added mass."""
    angle = 2.0 * math.pi * signals.motion.position / parameters.wavelength
    force = parameters.sine * math.sin(angle) + parameters.cosine * math.cos(angle)
    return force, 0.0


class ForceMemory(NamedTuple):
    """What the lagging signals are multiplied with, and how far they lag."""

    velocity: Annotated[float, Quantity('N', -1e3, 1e3, 'times v ahead of its lag, per 0.1 m/s')]
    difference: Annotated[float, Quantity('N', -1e3, 1e3, 'times lagging p1 - p2, per 5 bar')]
    lag: Annotated[float, LAG]


@Effect(
    title='a force with a memory, without a known cause',
    balance=Balance.FORCE,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source=SOURCE,
    null=ForceMemory(0.0, 0.0, 0.1),
    probes=tuple((0.5, 0.5, lag) for lag in (0.03, 0.2, 1.0, 5.0)),
    states=('velocity', 'difference'),
    describes=True,
)
def force_memory(
    signals: Signals, model: CompiledModel, parameters: ForceMemory, state: Floats, rate: Floats
) -> Pair:
    """Return the force along the outstroke [N] and no added mass."""
    if parameters.velocity == 0.0 and parameters.difference == 0.0:
        rate[:] = 0.0
        return 0.0, 0.0
    ahead = signals.motion.velocity / SPEED - state[0]
    difference = (signals.gas.pressure_1 - signals.gas.pressure_2) / PRESSURE
    rate[0] = ahead / parameters.lag
    rate[1] = (difference - state[1]) / parameters.lag
    return parameters.velocity * ahead + parameters.difference * state[1], 0.0


class FrictionMemory(NamedTuple):
    """What the lagging signals are multiplied with, and how far they lag."""

    speed: Annotated[float, Quantity('N', -1e3, 1e3, 'times the lagging |v|, per 0.1 m/s')]
    gauge_1: Annotated[float, Quantity('N', -1e3, 1e3, 'times the lagging gauge p1, per 5 bar')]
    gauge_2: Annotated[float, Quantity('N', -1e3, 1e3, 'times the lagging gauge p2, per 5 bar')]
    elapsed: Annotated[float, Quantity('N', -1e3, 1e3, 'times 1 - exp(-t / lag)')]
    lag: Annotated[float, LAG]


@Effect(
    title='a level of friction with a memory, without a known cause',
    balance=Balance.LEVEL,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source=SOURCE,
    null=FrictionMemory(0.0, 0.0, 0.0, 0.0, 0.1),
    probes=tuple((0.3, 0.3, 0.3, 0.3, lag) for lag in (0.03, 0.2, 1.0, 5.0)),
    states=('speed', 'gauge_1', 'gauge_2', 'elapsed'),
    describes=True,
)
def friction_memory(
    signals: Signals, model: CompiledModel, parameters: FrictionMemory, state: Floats, rate: Floats
) -> Pair:
    """Return what is added to F_c and to F_smax [N]."""
    p = parameters
    if p.speed == 0.0 and p.gauge_1 == 0.0 and p.gauge_2 == 0.0 and p.elapsed == 0.0:
        rate[:] = 0.0
        return 0.0, 0.0
    rate[0] = (abs(signals.motion.velocity) / SPEED - state[0]) / p.lag
    rate[1] = (gauge(signals.gas.pressure_1, model) - state[1]) / p.lag
    rate[2] = (gauge(signals.gas.pressure_2, model) - state[2]) / p.lag
    rate[3] = (1.0 - state[3]) / p.lag
    level = p.speed * state[0] + p.gauge_1 * state[1] + p.gauge_2 * state[2]
    level += p.elapsed * state[3]
    return level, level


class VoltageMemory(NamedTuple):
    """What the lagging voltages are multiplied with, and how far they lag."""

    behind_1: Annotated[float, Quantity('V', -3.0, 3.0, 'times how far u1 is ahead of its lag')]
    behind_2: Annotated[float, Quantity('V', -3.0, 3.0, 'times how far u2 is ahead of its lag')]
    elapsed_1: Annotated[float, Quantity('V', -3.0, 3.0, 'added to u1, times 1 - exp(-t / lag)')]
    elapsed_2: Annotated[float, Quantity('V', -3.0, 3.0, 'added to u2, times 1 - exp(-t / lag)')]
    lag: Annotated[float, LAG]


@Effect(
    title='an error of the valve spools with a memory, without a known cause',
    balance=Balance.SPOOL,
    regimes=(Regime.DWELL, Regime.SLIDING, Regime.END_STOP),
    source=SOURCE,
    null=VoltageMemory(0.0, 0.0, 0.0, 0.0, 0.1),
    probes=tuple((0.05, 0.05, 0.02, 0.02, lag) for lag in (0.02, 0.1, 0.5, 4.0)),
    stage=3,
    states=('behind_1', 'behind_2', 'elapsed_1', 'elapsed_2'),
    describes=True,
)
def voltage_memory(
    signals: Signals, model: CompiledModel, parameters: VoltageMemory, state: Floats, rate: Floats
) -> Pair:
    """
    Return what is added to the control voltages u1, u2 [V].

    The states are the voltages from the centre, and twice a step at the start.
    """
    p = parameters
    if p.behind_1 == 0.0 and p.behind_2 == 0.0 and p.elapsed_1 == 0.0 and p.elapsed_2 == 0.0:
        rate[:] = 0.0
        return 0.0, 0.0
    first, second = signals.ports.voltage_1, signals.ports.voltage_2
    ahead_1, ahead_2 = first - CENTRE_VOLTAGE - state[0], second - CENTRE_VOLTAGE - state[1]
    rate[0], rate[1] = ahead_1 / p.lag, ahead_2 / p.lag
    rate[2] = (1.0 - state[2]) / p.lag
    rate[3] = rate[2]
    error_1 = p.elapsed_1 * state[2] - p.behind_1 * ahead_1
    error_2 = p.elapsed_2 * state[3] - p.behind_2 * ahead_2
    return _within(error_1), _within(error_2)


@compiled
def _within(error: float) -> float:
    return min(max(error, -LARGEST_ERROR), LARGEST_ERROR)


EFFECTS: dict[str, Effect] = {
    'empirical_force_wave': force_wave,
    'empirical_force_memory': force_memory,
    'empirical_friction_memory': friction_memory,
    'empirical_voltage_memory': voltage_memory,
}
