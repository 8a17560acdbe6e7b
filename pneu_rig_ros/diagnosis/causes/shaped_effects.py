"""
Effects of another form: the formula of an effect times a free monotone factor.

The library has one formula for each mechanism. Where a real rig has another - heat transfer that
grows with pressure, a leak that is not linear - the mechanism is right and its formula is not. It
is then fitted with a factor over each of the variables that drive it, see ``model.shape``.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.causes.candidates import Candidate, Coordinate
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.shape import Shape, Shaped, without_shape
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE

KNOTS = 4
"""Of a factor: enough for a power law, a threshold or a saturation."""
STEEPEST = 8.0
"""Largest ratio of the factors at neighbouring knots [-]."""
START_RATIOS = (1.3, 2.5)
"""Ratios from which a fit starts [-]."""
COVERED = (0.02, 0.98)
"""Quantiles of a variable between which its knots lie: beyond there is too little to fit."""
TEMPERATURE_RANGE = 0.2
"""Relative difference of a gas temperature from that of the supply [-]."""
OVER = ' over '
"""Between the names of an effect and of a variable in that of a shaped effect."""


@dataclass(frozen=True)
class ShapedEffect(Candidate):
    """
    A factor of an effect over one variable; its coordinates are ratios of neighbouring knots.

    :param over: the variable, one of ``model.shape.DRIVERS``
    :param at: its knots, increasing [unit of the variable], shape (KNOTS,)
    """

    over: str = ''
    at: tuple[float, ...] = ()

    unit, size = '-', 1.0

    @property
    def effect(self) -> str:
        """Name of the effect of which it is another form."""
        return self.name.split(OVER)[0]

    def shape(self, values: Sequence[float]) -> Shape:
        """Return the factor with these ratios, of geometric mean 1 over the knots."""
        logarithms = np.concatenate([[0.0], np.cumsum(np.log(values))])
        factors = np.exp(logarithms - logarithms.mean())
        return Shape(self.over, self.at, tuple(float(factor) for factor in factors))

    def apply(self, hypothesis: Hypothesis, values: Sequence[float]) -> Hypothesis:
        """Return the hypothesis with the factor on its effect, which it must have."""
        parameters = without_shape(hypothesis.effects[self.effect])
        return hypothesis.with_effect(self.effect, Shaped(parameters, self.shape(values)))


def shaped_effects(
    effect: Candidate, runs: Sequence[Run], temperature: float
) -> Iterator[ShapedEffect]:
    """Yield an effect's rising and falling factors over each variable that varies in the runs."""
    for over in library.load(effect.name).drivers:
        at = knots(over, runs, temperature)
        if at is None:
            continue
        for sign in (1, -1):  # rising, falling
            low, high = sorted((1.0, STEEPEST**sign))
            quantity = Quantity('-', low, high, 'of the factors at neighbouring knots')
            ratios = tuple(
                Coordinate(f'ratio_{i}', quantity, low, high, 1.0, True, 1.0)
                for i in range(1, KNOTS)
            )
            starts = tuple((ratio**sign,) * (KNOTS - 1) for ratio in START_RATIOS)
            name = effect.name + OVER + over
            yield ShapedEffect(name, effect.group, ratios, starts, over=over, at=at)


def knots(
    over: str, runs: Sequence[Run], temperature: float, count: int = KNOTS
) -> tuple[float, ...] | None:
    """Return the knots over a variable [its unit]; None where it hardly varies."""
    values = np.concatenate([measured_values(over, run, temperature) for run in runs])
    if not values.size:
        return None
    low, high = np.quantile(values, COVERED)
    if over == 'dwell':
        at = np.geomspace(max(low, 1e-2), max(high, 1e-2), count)
    else:
        at = np.linspace(low, high, count)
    distinct = np.all(np.diff(at) > 1e-6 * max(abs(low), abs(high)))
    return tuple(float(knot) for knot in at) if distinct else None


def measured_values(over: str, run: Run, temperature: float) -> Floats:
    """Return the values of a variable in a run, as far as it is measured, shape (n,)."""
    x, p1, p2 = run.smooth.T
    moving = run.velocity[run.sliding]
    rests = [run.operation.rest_time, *((r.end - r.first) * run.interval for r in run.rests)]
    table: dict[str, Floats] = {
        'position': x,
        'velocity': moving,
        'speed': np.abs(moving),
        'time': run.time,
        'pressure_1': p1,
        'pressure_2': p2,
        'difference': np.abs(p1 - p2),
        'pressure': np.concatenate([p1, p2]),
        'temperature': temperature * np.array([1.0 - TEMPERATURE_RANGE, 1.0 + TEMPERATURE_RANGE]),
        'dwell': np.array(rests),
        'opening': (run.voltages - CENTRE_VOLTAGE).ravel(),
    }
    return table[over]
