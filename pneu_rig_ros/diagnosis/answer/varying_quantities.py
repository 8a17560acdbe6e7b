"""Quantities that may change from recording to recording: conditions, and what wears of a seal."""

from collections.abc import Sequence
from dataclasses import dataclass

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.causes.candidates import (
    CONDITIONS,
    FORCE,
    PARAMETER_RATIO,
    Candidate,
    Coordinate,
)
from pneu_rig_ros.diagnosis.inputs.system import value_of
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset
from pneu_rig_ros.diagnosis.search.fitting import STEP
from pneu_rig_ros.model.quantity import Quantity


@dataclass(frozen=True)
class FrictionLevel(Candidate):
    """The level of friction, Coulomb and breakaway force, relative to the model's."""

    def apply(self, hypothesis: Hypothesis, values: Sequence[float]) -> Hypothesis:
        """Return the hypothesis with both forces multiplied."""
        friction = hypothesis.model.friction
        for name in ('coulomb_force', 'breakaway_force'):
            value = values[0] * getattr(friction, name)
            hypothesis = hypothesis.with_parameter('friction', name, value)
        return hypothesis


CHANGING = 'friction.coulomb_force', 'friction.breakaway_force', 'friction.viscous_coefficient'
"""Parameters that may change from recording to recording, as conditions do."""
RATIO = Quantity('-', 1.0 / PARAMETER_RATIO, PARAMETER_RATIO, "times the model's")
LEVEL = FrictionLevel(
    CONDITIONS + 'friction_level',
    FORCE,
    (Coordinate('times', RATIO, RATIO.low, RATIO.high, 1.0, True, 1.0),),
    ((1.0,),),
)
"""What wear, lubrication and warmth change."""


def varying_quantities(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return the quantities among candidates that may change from recording to recording."""
    quantities = {c.name: c for c in candidates if c.is_condition or c.name in CHANGING}
    if any(quantity.group == FORCE for quantity in quantities.values()):
        quantities[LEVEL.name] = LEVEL
    return list(quantities.values())


def key_of(quantity: Candidate) -> str:
    """Return the name of a quantity without its section."""
    return quantity.name.split('.')[-1]


def unit_of(quantity: Candidate) -> float:
    """Return the unit of its internal values: 1 for a ratio, to the first order."""
    (c,) = quantity.coordinates
    return 1.0 if c.logarithmic else c.scale


def changes(quantity: Candidate, hypothesis: Hypothesis, run: Dataset, residual: Floats) -> Floats:
    """
    Return the derivative of the whitened residuals of a run by a quantity, shape (n,).

    :param residual: they themselves
    """
    value = value_in(quantity, hypothesis)
    moved = quantity.apply(hypothesis, (value + STEP * scale_at(quantity, value),))
    derivative: Floats = (run.whitened(moved) - residual) / STEP
    return derivative


def value_in(quantity: Candidate, hypothesis: Hypothesis) -> float:
    """Return the value of a quantity in a hypothesis [unit]."""
    if quantity.is_condition:
        return hypothesis.conditions.get(
            quantity.name.removeprefix(CONDITIONS), quantity.coordinates[0].null
        )
    return value_of(hypothesis.model, quantity.name)


def scale_at(quantity: Candidate, value: float) -> float:
    """Return by how much a quantity changes with its internal value, at some value [unit]."""
    (c,) = quantity.coordinates
    return value if c.logarithmic else c.scale
