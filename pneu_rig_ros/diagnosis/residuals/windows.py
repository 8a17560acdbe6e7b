"""The windows of the residuals with their regime and the signals in them."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.arrays import Flags, Floats
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.balances import BALANCES, Comparison
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset
from pneu_rig_ros.diagnosis.residuals.weak_form import TestFunctions
from pneu_rig_ros.diagnosis.residuals.whitening import Whitener
from pneu_rig_ros.model import along
from pneu_rig_ros.model.effect import Regime

VARIABLES = ('position', 'velocity', 'pressure_1', 'pressure_2', 'dwell')
DWELL, BREAKAWAY = Regime.DWELL.label, Regime.BREAKAWAY.label
SLIDING, END_STOP = Regime.SLIDING.label, Regime.END_STOP.label
NEAR_BREAKAWAY = 0.1
"""A window this close to a breakaway is of that regime [s]."""


@dataclass(frozen=True)
class Windows:
    """
    The kept windows of one kind of residual in one run.

    :param balance: one of ``BALANCES``
    :param recording: name of the run
    :param start, end: of each window [s], shape (m,)
    :param residual: in the unit of the balance, shape (m,)
    :param deviation: its standard deviation, shape (m,)
    :param whitened: independent, of standard deviation 1, shape (m,)
    :param whiten: the whitener, for all windows
    :param factor: inflation of the noise, shape (m,)
    :param regime, direction: of each, shape (m,)
    :param variables: signal -> mean in each window, shape (m,); the dwell, NaN while it moves, is
        how long the piston has rested [s]
    :param repeatability: by which recordings of the system differ from its model [unit]
    """

    balance: str
    recording: str
    start: Floats
    end: Floats
    residual: Floats
    deviation: Floats
    whitened: Floats
    whiten: Whitener
    factor: Floats
    regime: NDArray[np.str_]
    direction: NDArray[np.str_]
    variables: dict[str, Floats]
    repeatability: float = 0.0

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
        :return: shape (m, k)
        """
        ones = np.array(cells, dtype=np.float64).T
        whitened: Floats = self.whiten.columns(ones) / self.factor[:, np.newaxis]
        return whitened


def windows_of(dataset: Dataset, hypothesis: Hypothesis) -> list[Windows]:
    """Return the windows of all balances in all runs; breakaways and stops are of the force."""
    windows = []
    runs = zip(dataset.comparisons, dataset.factors, dataset.evaluate(hypothesis), strict=True)
    for comparison, factors, (residuals, noise, whitened) in runs:
        places = [_windows(comparison, comparison.gas, noise[i].kept, gas=True) for i in (0, 1)]
        places.append(_windows(comparison, comparison.motion, noise.force.kept, gas=False))
        places.append(_breakaways(comparison, noise.breakaway.kept))
        places.append(_windows(comparison, comparison.stops, noise.stop.kept, gas=False))
        for i, (start, end, regime, direction, variables) in enumerate(places):
            if start.size:
                whiten = noise[i]
                residual = residuals[i][whiten.kept], whiten.deviation, whitened[i]
                balance = (*BALANCES, 'force', 'force')[i]
                place = balance, comparison.run.name, start, end
                kind = regime, direction, variables
                differs = comparison.run.repeatability.get(balance, 0.0)
                differs = 0.0 if whiten is noise.stop else differs
                windows.append(Windows(*place, *residual, whiten, factors[i], *kind, differs))
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


Places = tuple[Floats, Floats, NDArray[np.str_], NDArray[np.str_], dict[str, Floats]]
"""Start, end, regime, direction and variables of windows."""


def _windows(comparison: Comparison, functions: TestFunctions, kept: Flags, gas: bool) -> Places:
    """Return where the kept windows are; the regime is that for most of a window."""
    run = comparison.run
    x, p1, p2 = (0.5 * (run.smooth[1:] + run.smooth[:-1])).T
    signals = dict(zip(VARIABLES, (x, run.velocity, p1, p2, dwell(run)), strict=True))
    variables = {name: functions.averages(values)[kept] for name, values in signals.items()}
    start = run.begin + functions.starts[kept].astype(np.float64) * run.interval
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
    regime = regime[kept]
    moving = (regime == SLIDING) | (regime == BREAKAWAY)
    direction = np.where(variables['velocity'] >= 0.0, 'out', 'in')
    end = start + functions.size * run.interval
    return start, end, regime, np.where(moving, direction, ''), variables


def _breakaways(comparison: Comparison, kept: Flags) -> Places:
    """Return where the kept breakaways are, with the velocity that follows."""
    run, ends = comparison.run, comparison.breakaways[kept]
    time = run.begin + ends.astype(np.float64) * run.interval
    x, p1, p2 = (0.5 * (run.smooth[1:] + run.smooth[:-1]))[ends].T
    after = np.minimum(ends + round(NEAR_BREAKAWAY / run.interval), run.size - 2)
    velocity = run.velocity[after]
    variables = dict(zip(VARIABLES, (x, velocity, p1, p2, dwell(run)[ends]), strict=True))
    direction = np.where(velocity >= 0.0, 'out', 'in')
    regime = np.full(ends.size, BREAKAWAY)
    return time - NEAR_BREAKAWAY, time + NEAR_BREAKAWAY, regime, direction, variables
