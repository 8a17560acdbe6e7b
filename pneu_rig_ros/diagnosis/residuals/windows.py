"""The windows of the residuals with their regime and the signals in them."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.arrays import Flags, Floats
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.balances import BALANCES, Comparison
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset
from pneu_rig_ros.diagnosis.residuals.weak_form import TestFunctions, middles
from pneu_rig_ros.diagnosis.residuals.whitening import Whitener
from pneu_rig_ros.model import along
from pneu_rig_ros.model.effect import Regime

VARIABLES = ('position', 'velocity', 'pressure_1', 'pressure_2', 'dwell')
DWELL, BREAKAWAY = Regime.DWELL.label, Regime.BREAKAWAY.label
SLIDING, END_STOP = Regime.SLIDING.label, Regime.END_STOP.label
OF_KIND = *BALANCES, 'force', 'force'
"""Balance of each kind of residual."""
NEAR_BREAKAWAY = 0.1
"""A window this close to a breakaway is of that regime [s]."""


@dataclass(frozen=True, eq=False)
class Windows:
    """
    The kept windows of one kind of residual in one run.

    :param balance: one of ``BALANCES``
    :param recording: name of the run
    :param start, end: of each window [s], shape (m,)
    :param regime, direction: of each, shape (m,)
    :param variables: signal -> mean in each window, shape (m,); the dwell, NaN while it moves, is
        how long the piston has rested [s]
    :param residual: in the unit of the balance, shape (m,)
    :param whitened: independent, of standard deviation 1, shape (m,)
    :param whiten: the whitener, for all windows
    :param factor: inflation of the noise, shape (m,)
    :param repeatability: by which recordings of the system differ from its model [unit]
    """

    balance: str
    recording: str
    start: Floats
    end: Floats
    regime: NDArray[np.str_]
    direction: NDArray[np.str_]
    variables: dict[str, Floats]
    residual: Floats
    whitened: Floats
    whiten: Whitener
    factor: Floats
    repeatability: float = 0.0

    @property
    def deviation(self) -> Floats:
        """Standard deviation of the residuals without inflation [unit], shape (m,)."""
        return self.whiten.deviation

    @property
    def at_stops(self) -> bool:
        """Whether these are readings at end stops, in the unit of a position."""
        return self.balance == 'force' and self.regime[0] == END_STOP

    @cached_property
    def middle(self) -> Floats:
        """Middles of the windows [s], shape (m,)."""
        return 0.5 * (self.start + self.end)

    def indicators(self, cells: Sequence[Flags]) -> Floats:
        """
        Return the whitened forms of residuals that are 1 in the windows of a cell, 0 elsewhere.

        :param cells: windows of each of k cells, shape (m,) each
        :return: shape (k, m)
        """
        ones = np.array(cells, dtype=np.float64).T
        whitened = self.whiten.columns(ones) / self.factor[:, np.newaxis]
        return np.ascontiguousarray(whitened.T)


def windows_of(dataset: Dataset, hypothesis: Hypothesis) -> list[Windows]:
    """Return the windows of all balances in all runs; breakaways and stops are of the force."""
    windows = []
    for data, evaluation in zip(dataset.runs, dataset.evaluate(hypothesis), strict=True):
        comparison, run = data.comparison, data.comparison.run
        gas = _places(comparison, comparison.gas, gas=True)
        motion = _places(comparison, comparison.motion, gas=False)
        stops = _places(comparison, comparison.stops, gas=False)
        places = gas, gas, motion, _breakaways(comparison), stops
        for i, (balance, whiten) in enumerate(zip(OF_KIND, evaluation.noise, strict=True)):
            kept = whiten.kept
            if kept.any():
                start, end, regime, direction, *values = (each[kept] for each in places[i])
                variables = dict(zip(VARIABLES, values, strict=True))
                place = balance, run.name, start, end, regime, direction, variables
                own = evaluation.residuals[i][kept], evaluation.whitened[i]
                differs = run.repeatability.get(balance, 0.0) if places[i] is not stops else 0.0
                windows.append(Windows(*place, *own, whiten, data.factors[i], differs))
    return windows


def dwell(run: Run) -> Floats:
    """Return how long a free piston has rested in each interval [s], NaN where it moves."""
    times = np.full(run.size - 1, np.nan)
    if run.noise.position > 0.0:
        for rest in run.rests:
            before = run.operation.rest_time if rest.first == 0 else 0.0
            inside = slice(rest.first, rest.end - 1)
            times[inside] = before + run.time[inside] - rest.first * run.interval
    times[run.contacts == along.MOVES] = np.nan  # a bench holds the piston, not the seal
    return times


Places = tuple[NDArray[Any], ...]
"""Start, end, regime, direction and each of ``VARIABLES`` of windows, shape (m,)."""


def _signals(run: Run) -> tuple[Floats, ...]:
    """Return each of ``VARIABLES`` in the intervals, shape (n - 1,)."""
    x, p1, p2 = middles(run.smooth).T
    return x, run.velocity, p1, p2, dwell(run)


def _places(comparison: Comparison, functions: TestFunctions, gas: bool) -> Places:
    """Return where windows are; the regime is that for most of a window."""
    run = comparison.run
    means = [functions.averages(values) for values in _signals(run)]
    start = run.begin + functions.starts.astype(np.float64) * run.interval
    resting = functions.averages((run.contacts == along.RESTS).astype(np.float64))
    stopped = functions.averages((run.contacts >= along.AT_INNER_STOP).astype(np.float64))
    regime = np.full(resting.size, SLIDING, dtype='<U9')
    regime[resting > 0.5] = DWELL
    # a volume that is constant has no stops
    regime[stopped > 0.5] = END_STOP if run.noise.position > 0.0 else DWELL
    if gas:  # the force has residuals of its own at a breakaway
        middle = (functions.starts + 0.5 * functions.size) * run.interval
        for end in comparison.breakaways * run.interval:
            regime[np.abs(middle - end) < NEAR_BREAKAWAY] = BREAKAWAY
    moving = (regime == SLIDING) | (regime == BREAKAWAY)
    direction = np.where(moving, np.where(means[1] >= 0.0, 'out', 'in'), '')
    return start, start + functions.size * run.interval, regime, direction, *means


def _breakaways(comparison: Comparison) -> Places:
    """Return where the breakaways are, with the velocity that follows."""
    run, ends = comparison.run, comparison.breakaways
    time = run.begin + ends.astype(np.float64) * run.interval
    x, _, p1, p2, rested = (values[ends] for values in _signals(run))
    after = np.minimum(ends + round(NEAR_BREAKAWAY / run.interval), run.size - 2)
    velocity = run.velocity[after]
    kind = np.full(ends.size, BREAKAWAY), np.where(velocity >= 0.0, 'out', 'in')
    return time - NEAR_BREAKAWAY, time + NEAR_BREAKAWAY, *kind, x, velocity, p1, p2, rested
