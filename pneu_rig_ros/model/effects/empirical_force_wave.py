"""A force that is periodic in the position, without a known cause: a detent, a thread, cogging."""

import math
from typing import Annotated, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled import compiled
from pneu_rig_ros.model.compiled_model import CompiledModel
from pneu_rig_ros.model.effect import Balance, Effect, Regime, Signals
from pneu_rig_ros.model.quantity import Quantity


class Parameters(NamedTuple):
    """Amplitudes and wavelength of the force."""

    sine: Annotated[float, Quantity('N', -1e3, 1e3, 'force, times sin(2 pi x / wavelength)')]
    cosine: Annotated[float, Quantity('N', -1e3, 1e3, 'force, times cos(2 pi x / wavelength)')]
    wavelength: Annotated[float, Quantity('m', 1e-3, 2.0, 'way from one crest to the next')]


@compiled
def contribution(
    signals: Signals, model: CompiledModel, parameters: Parameters, state: Floats, rate: Floats
) -> tuple[float, float]:
    """Return the force along the outstroke [N] and no added mass."""
    angle = 2.0 * math.pi * signals.motion.position / parameters.wavelength
    force = parameters.sine * math.sin(angle) + parameters.cosine * math.cos(angle)
    return force, 0.0


EFFECT = Effect(
    title='a force periodic in the position, without a known cause',
    balance=Balance.FORCE,
    regimes=(Regime.BREAKAWAY, Regime.SLIDING),
    source='a fit to data: a description, not a cause',
    null=Parameters(0.0, 0.0, 0.02),
    contribution=contribution,
    probes=(Parameters(0.5, 0.5, 0.02), Parameters(0.5, 0.5, 0.05)),
    describes=True,
)
