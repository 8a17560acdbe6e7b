"""
Where a hypothesis disagrees: balance, regime, range of a signal, time.

The windows of the residuals are parted into cells. In each the mean is found by generalised least
squares, and whether the cell spreads more than noise; of all cells of all balances together, those
are told that keep the share of false ones below 5 % (Y. Benjamini, Y. Hochberg, J. R. Stat. Soc. B
57 (1995) 289).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, false_discovery_control, norm

from pneu_rig_ros.diagnosis.balances import Comparison
from pneu_rig_ros.diagnosis.dataset import Dataset
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.noise import Whitener
from pneu_rig_ros.diagnosis.weak_form import Floats, TestFunctions
from pneu_rig_ros.model import along

Flags = NDArray[np.bool_]

FALSE_DISCOVERIES = 0.05
"""Share of the cells told that may be none [-]."""
NOISE_KNOWN = 1.1
"""The noise is known to 10 %: what a cell exceeds it by less is none [-]."""
LARGEST = 2.5
"""Standard deviations as which a window counts that is farther off: one is no cell."""
BINS = 4
"""Parts into which the range of a signal is divided, by quantiles."""
LEAST = {'position': 1e-3, 'velocity': 3e-3, 'pressure_1': 2e3, 'pressure_2': 2e3}
"""
Least width of a part [SI]: many times the noise of the signal, or it would be the noise by which
the windows are told apart.
"""
SPAN = 1.0
"""Length of the stretches of time that are cells [s]."""
FEWEST = 5
"""Windows of a cell at least."""
BREAKS = 0.1
"""A window so close to a breakaway is of that regime [s]."""

BALANCES = ('gas_1', 'gas_2', 'force')
UNITS = {'gas_1': 'kg/s', 'gas_2': 'kg/s', 'force': 'N'}
VARIABLES = ('position', 'velocity', 'pressure_1', 'pressure_2')
DWELL, BREAKAWAY, SLIDING, END_STOP = 'dwell', 'breakaway', 'sliding', 'end stop'


@dataclass(frozen=True)
class Windows:
    """
    The windows of one kind of residual in one run that say something.

    :param balance: one of ``BALANCES``
    :param recording: name of the run
    :param start, end: of each window [s], shape (m,)
    :param residual: in the unit of the balance, shape (m,)
    :param deviation: its standard deviation, shape (m,)
    :param whitened: independent, of standard deviation 1, shape (m,)
    :param whiten: what makes them so, of all windows
    :param factor: by which the noise is wider, shape (m,)
    :param regime, direction: of each, shape (m,)
    :param variables: signal -> mean in each window, shape (m,)
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

    @cached_property
    def middle(self) -> Floats:
        """Middles of the windows [s], shape (m,)."""
        return 0.5 * (self.start + self.end)

    def indicator(self, cell: Flags) -> Floats:
        """Return what a residual of 1 in the windows of a cell is when it is whitened."""
        every = np.zeros(self.whiten.kept.size)
        every[np.flatnonzero(self.whiten.kept)[cell]] = 1.0
        return self.whiten(every) / self.factor


@dataclass(frozen=True)
class SignificantResidual:
    """
    A regime of a balance that disagrees, and where in it most.

    :param mean: of the residual in the cell that disagrees most [unit]
    :param noise: standard deviation of the mean [unit]
    :param p_value: that noise alone makes a cell disagree so much
    :param variable: signal by which the cell is bounded, 'time', or '' for the whole regime
    :param low, high: bounds, None for the whole
    :param intervals: recording, from, to [s] of the significant stretches of time
    """

    balance: str
    regime: str
    direction: str
    unit: str
    mean: float
    noise: float
    p_value: float
    variable: str
    low: float | None
    high: float | None
    recordings: tuple[str, ...]
    intervals: tuple[tuple[str, float, float], ...]

    @property
    def significance(self) -> float:
        """How many standard deviations noise would need for it, by its p-value [-]."""
        return float(norm.isf(0.5 * max(self.p_value, 1e-300)))


def windows_of(dataset: Dataset, hypothesis: Hypothesis) -> list[Windows]:
    """Return the windows of all balances in all runs, breakaways as windows of the force."""
    found = []
    runs = zip(
        dataset.comparisons, dataset.noises_under(hypothesis), dataset.factors,
        dataset.of_each(hypothesis), strict=True,
    )  # fmt: skip
    for comparison, noise, factors, whitened in runs:
        raw = comparison.residuals(hypothesis)
        for index, balance in enumerate(BALANCES):
            functions = comparison.motion if balance == 'force' else comparison.gas
            kept = noise[index].kept
            found.append(_windows(comparison, functions, balance, raw[index][kept],
                                  whitened[index], noise[index], factors[index]))  # fmt: skip
        found.append(_breakaways(comparison, raw.breakaway, whitened.breakaway, noise.breakaway,
                                 factors.breakaway))  # fmt: skip
    return [one for one in found if one.residual.size]


def _windows(
    comparison: Comparison, functions: TestFunctions, balance: str, residual: Floats,
    whitened: Floats, whiten: Whitener, factor: Floats,
) -> Windows:  # fmt: skip
    run, kept = comparison.run, whiten.kept
    middles = np.column_stack(
        [0.5 * (run.smooth[1:] + run.smooth[:-1]), run.velocity]
    )[:, [0, 3, 1, 2]]  # fmt: skip
    variables = {
        name: functions.plain_means(middles[:, i])[kept] for i, name in enumerate(VARIABLES)
    }
    starts = run.begin + functions.starts[kept].astype(np.float64) * run.interval
    ends = starts + functions.size * run.interval
    regimes = _regimes(comparison, functions, balance)[kept]
    directions = np.where(variables['velocity'] >= 0.0, 'out', 'in')
    moving = (regimes == SLIDING) | (regimes == BREAKAWAY)
    return Windows(balance, run.name, starts, ends, residual, whiten.deviation, whitened, whiten,
                   factor, regimes, np.where(moving, directions, ''), variables)  # fmt: skip


def _regimes(comparison: Comparison, functions: TestFunctions, balance: str) -> NDArray[np.str_]:
    """Return the regime of each window: what the piston does for most of it."""
    contacts = comparison.run.contacts
    resting = functions.plain_means((contacts == along.RESTS).astype(np.float64))
    stopped = functions.plain_means((contacts >= along.AT_INNER_STOP).astype(np.float64))
    regimes = np.full(resting.size, SLIDING, dtype='<U9')
    regimes[resting > 0.5] = DWELL
    regimes[stopped > 0.5] = END_STOP
    if balance != 'force':
        interval = comparison.run.interval
        middle = (functions.starts + 0.5 * functions.size) * interval
        for end in comparison.ends * interval:
            regimes[np.abs(middle - end) < BREAKS] = BREAKAWAY
    return regimes


def _breakaways(
    comparison: Comparison, residual: Floats, whitened: Floats, whiten: Whitener, factor: Floats
) -> Windows:
    run, kept = comparison.run, whiten.kept
    ends = comparison.ends[kept]
    time = run.begin + ends.astype(np.float64) * run.interval
    middles = 0.5 * (run.smooth[1:] + run.smooth[:-1])
    after = np.minimum(ends + round(BREAKS / run.interval), run.size - 2)
    velocity = run.velocity[after]
    columns = (middles[ends, 0], velocity, middles[ends, 1], middles[ends, 2])
    variables = dict(zip(VARIABLES, columns, strict=True))
    regimes = np.full(ends.size, BREAKAWAY)
    directions = np.where(velocity >= 0.0, 'out', 'in')
    return Windows('force', run.name, time - BREAKS, time + BREAKS, residual[kept],
                   whiten.deviation, whitened, whiten, factor, regimes,
                   directions, variables)  # fmt: skip


@dataclass(frozen=True)
class Cell:
    """Windows of a regime of a balance: which of each group, and what bounds them."""

    balance: str
    regime: str
    direction: str
    variable: str
    low: float | None
    high: float | None
    members: tuple[tuple[Windows, Flags], ...]


def cells(groups: Sequence[Windows]) -> Iterator[Cell]:
    """Yield all cells that have enough windows."""
    places = {
        (g.balance, str(regime), str(direction))
        for g in groups
        for regime, direction in zip(g.regime, g.direction, strict=True)
    }
    for balance, regime, direction in sorted(places):
        here = [(g, (g.regime == regime) & (g.direction == direction))
                for g in groups if g.balance == balance]  # fmt: skip
        here = [(g, flags) for g, flags in here if flags.any()]
        place = balance, regime, direction
        for cell in (Cell(*place, '', None, None, tuple(here)), *_bins(place, here),
                     *_stretches(place, here)):  # fmt: skip
            if sum(int(flags.sum()) for _, flags in cell.members) >= FEWEST:
                yield cell


Members = Sequence[tuple[Windows, Flags]]


def _bins(place: tuple[str, str, str], members: Members) -> Iterator[Cell]:
    for variable in VARIABLES:
        values = np.concatenate([g.variables[variable][flags] for g, flags in members])
        edges = apart(np.quantile(values, np.linspace(0.0, 1.0, BINS + 1)), LEAST[variable])
        if edges.size < 3:
            continue
        edges[-1] = np.nextafter(edges[-1], np.inf)
        for low, high in pairwise(edges):
            parts = [(g, flags & (g.variables[variable] >= low) & (g.variables[variable] < high))
                     for g, flags in members]  # fmt: skip
            yield Cell(*place, variable, float(low), float(high), tuple(parts))


def apart(edges: Floats, least: float) -> Floats:
    """Return edges without those that are next to another one, shape (k,)."""
    kept = [float(edges[0])]
    for edge in edges[1:-1]:
        if edge - kept[-1] >= least and edges[-1] - edge >= least:
            kept.append(float(edge))
    return np.array([*kept, float(edges[-1])])


def _stretches(place: tuple[str, str, str], members: Members) -> Iterator[Cell]:
    for group, flags in members:
        numbers = (group.middle // SPAN).astype(np.intp)
        for number in np.unique(numbers[flags]):
            inside = flags & (numbers == number)
            yield Cell(*place, 'time', float(group.start[inside].min()),
                       float(group.end[inside].max()), ((group, inside),))  # fmt: skip


def tested(cell: Cell) -> tuple[float, float, float]:
    """Return mean and standard deviation of a cell [unit], and its p-value."""
    top = bottom = squares = mean = 0.0
    count = 0
    for group, flags in cell.members:
        weights = group.indicator(flags)
        within = np.clip(group.whitened, -LARGEST, LARGEST)
        top += float(weights @ within)
        mean += float(weights @ group.whitened)
        bottom += float(weights @ weights)
        squares += float(np.sum(within[flags] ** 2))
        count += int(flags.sum())
    z = top / np.sqrt(bottom) / NOISE_KNOWN
    p_mean = 2.0 * float(norm.sf(abs(z)))
    p_spread = float(chi2.sf(squares / NOISE_KNOWN**2, count))
    return mean / bottom, 1.0 / np.sqrt(bottom), min(2.0 * min(p_mean, p_spread), 1.0)


def localise(groups: Sequence[Windows]) -> list[SignificantResidual]:
    """Return where the residuals disagree, the most significant regime first."""
    every = list(cells(groups))
    if not every:
        return []
    results = [tested(cell) for cell in every]
    adjusted = false_discovery_control([p for _, _, p in results])
    places: dict[tuple[str, str, str], list[tuple[Cell, tuple[float, float, float]]]] = {}
    for cell, result, rate in zip(every, results, adjusted, strict=True):
        if rate < FALSE_DISCOVERIES:
            place = cell.balance, cell.regime, cell.direction
            places.setdefault(place, []).append((cell, result))
    found = [_disagreement(significant) for significant in places.values()]
    return sorted(found, key=lambda one: one.p_value)


def _disagreement(
    significant: Sequence[tuple[Cell, tuple[float, float, float]]],
) -> SignificantResidual:
    cell, (mean, noise, p_value) = min(significant, key=lambda pair: pair[1][2])
    spans = [
        (one.members[0][0].recording, float(one.low or 0.0), float(one.high or 0.0))
        for one, _ in significant
        if one.variable == 'time'
    ]
    names = dict.fromkeys(g.recording for one, _ in significant for g, _ in one.members)
    return SignificantResidual(
        cell.balance, cell.regime, cell.direction, UNITS[cell.balance], mean, noise, p_value,
        cell.variable, cell.low, cell.high, tuple(names), tuple(spans),
    )  # fmt: skip
