"""
Localisation: balance, regime, range of a signal and time of significant residuals.

The windows are divided into cells. Each cell is tested for its mean, by generalised least squares,
and for its spread. The false-discovery rate is controlled over the regimes of all balances (Y.
Benjamini, Y. Hochberg, J. R. Stat. Soc. B 57 (1995) 289), and over the cells of those that are
significant (Y. Benjamini, M. Bogomolov, J. R. Stat. Soc. B 76 (2014) 297).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, groupby, pairwise
from typing import NamedTuple

import numpy as np
from scipy.special import chdtrc, ndtr  # of single values ten times as fast as scipy.stats
from scipy.stats import false_discovery_control, norm

from pneu_rig_ros.arrays import Flags, Floats
from pneu_rig_ros.diagnosis.residuals.balances import STOP_UNIT, UNITS
from pneu_rig_ros.diagnosis.residuals.windows import VARIABLES, Windows

FALSE_DISCOVERY_RATE = 0.05
"""Expected share of false ones among the significant regimes, and among the cells of each [-]."""
NOISE_ERROR = 1.1
"""The noise is known to 10 %: a smaller excess is not significant [-]."""
LARGEST_RESIDUAL = 2.5
"""Standard deviations to which a residual is clipped, so that one alone is not significant."""
BINS = 4
"""Parts into which the range of a signal is divided, by quantiles."""
LEAST_WIDTH = {
    'position': 1e-3,
    'velocity': 3e-3,
    'pressure_1': 2e3,
    'pressure_2': 2e3,
    'dwell': 0.1,
}
"""
Least width of a part [SI]: many times the noise of the signal, by which windows would else be
sorted. When a rest begins and ends is known to some 50 ms.
"""
STRETCH = 1.0
"""Length of the stretches of time that are cells [s]."""
FEWEST_WINDOWS = 5
"""Cells with fewer windows are ignored."""

Members = Sequence[tuple[Windows, Flags]]


@dataclass(frozen=True)
class SignificantResidual:
    """
    A regime of a balance with significant cells, described by the most significant one.

    :param mean: of the residual in that cell [unit]
    :param noise: standard deviation of the mean [unit]
    :param p_value: of that cell
    :param variable: signal by which the cell is bounded, 'time', or '' for the whole regime
    :param low, high: bounds, None for the whole
    :param intervals: recording, from, to [s] of the significant stretches of time
    :param parts: signal, from, to [SI] of the significant parts of its range, the most significant
        first
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
    parts: tuple[tuple[str, float, float], ...] = ()

    @property
    def significance(self) -> float:
        """The p-value in standard deviations of a normal distribution [-]."""
        return float(norm.isf(0.5 * max(self.p_value, 1e-300)))


@dataclass(frozen=True)
class Cell:
    """
    Windows of one regime of a balance.

    :param place: balance, regime, direction
    :param variable, low, high: signal and bounds of the cell, see ``SignificantResidual``
    :param members: groups of windows with those of the cell flagged
    """

    place: tuple[str, str, str]
    variable: str
    low: float | None
    high: float | None
    members: Members


class CellTest(NamedTuple):
    """
    Mean of the residual in a cell and its standard deviation [unit], and its significance.

    :param p_value: of the mean and of the spread together
    :param excess: sum of squares beyond that of noise: of all windows, or of their mean [-]
    """

    mean: float
    deviation: float
    p_value: float
    excess: float


def cell_test(cell: Cell, indicators: Sequence[Floats]) -> CellTest:
    """Return the test of a cell with the indicators of each member, see ``Windows``."""
    top = bottom = clipped_squares = squares = mean = 0.0
    count, differs = 0, 0.0
    for (group, flags), weights in zip(cell.members, indicators, strict=True):
        clipped = np.clip(group.whitened, -LARGEST_RESIDUAL, LARGEST_RESIDUAL)
        top += float(weights @ clipped)
        mean += float(weights @ group.whitened)
        bottom += float(weights @ weights)
        clipped_squares += float(np.sum(clipped[flags] ** 2))
        squares += float(np.sum(group.whitened[flags] ** 2))
        count += int(flags.sum())
        differs = max(differs, group.repeatability)
    # what differs from recording to recording does not average out over the windows of a cell
    deviation = np.hypot(NOISE_ERROR / np.sqrt(bottom), differs)
    p_mean = 2.0 * float(ndtr(-abs(top / bottom) / deviation))
    spread = float(chdtrc(count, clipped_squares / NOISE_ERROR**2))
    p_spread = spread if differs == 0.0 else 1.0
    square = mean * mean / bottom  # infinite where a start is absurd; a power would raise an error
    excess = max(squares - count * NOISE_ERROR**2, square - NOISE_ERROR**2, 0.0)
    p_value = min(2.0 * min(p_mean, p_spread), 1.0)
    return CellTest(mean / bottom, 1.0 / np.sqrt(bottom), p_value, excess)


def cell_tests(cells: Sequence[Cell]) -> list[CellTest]:
    """Return the tests of all cells; the indicators of a group are whitened in one go."""
    flags: dict[Windows, list[Flags]] = {}
    for group, members in (member for cell in cells for member in cell.members):
        flags.setdefault(group, []).append(members)
    rows = {group: iter(group.indicators(each)) for group, each in flags.items()}
    return [cell_test(cell, [next(rows[group]) for group, _ in cell.members]) for cell in cells]


def cells(groups: Sequence[Windows]) -> Iterator[Cell]:
    """Yield the cells of all regimes: the whole, parts of each signal's range, stretches."""
    places = {
        (group.balance, str(regime), str(direction))
        for group in groups
        for regime, direction in zip(group.regime, group.direction, strict=True)
    }
    for place in sorted(places):
        balance, regime, direction = place
        members = []
        for group in groups:
            flags = (group.regime == regime) & (group.direction == direction)
            if group.balance == balance and flags.any():
                members.append((group, flags))
        whole = Cell(place, '', None, None, members)
        for cell in (whole, *_bins(place, members), *_stretches(place, members)):
            if sum(int(flags.sum()) for _, flags in cell.members) >= FEWEST_WINDOWS:
                yield cell


def _bins(place: tuple[str, str, str], members: Members) -> Iterator[Cell]:
    for variable in VARIABLES:
        values = np.concatenate([group.variables[variable][flags] for group, flags in members])
        values = values[np.isfinite(values)]
        if values.size < FEWEST_WINDOWS:
            continue
        quantiles = np.quantile(values, np.linspace(0.0, 1.0, BINS + 1))
        edges = spaced(quantiles, LEAST_WIDTH[variable])
        if edges.size < 3:
            continue
        edges[-1] = np.nextafter(edges[-1], np.inf)
        for low, high in pairwise(edges):
            parts = []
            for group, flags in members:
                values = group.variables[variable]
                parts.append((group, flags & (values >= low) & (values < high)))
            yield Cell(place, variable, float(low), float(high), parts)


def spaced(edges: Floats, least: float) -> Floats:
    """Return edges without those that are too close to another one, shape (k,)."""
    kept = [float(edges[0])]
    for edge in edges[1:-1]:
        if edge - kept[-1] >= least and edges[-1] - edge >= least:
            kept.append(float(edge))
    return np.array([*kept, float(edges[-1])])


def _stretches(place: tuple[str, str, str], members: Members) -> Iterator[Cell]:
    for group, flags in members:
        numbers = (group.middle // STRETCH).astype(np.intp)
        for number in np.unique(numbers[flags]):
            inside = flags & (numbers == number)
            begin, end = float(group.start[inside].min()), float(group.end[inside].max())
            yield Cell(place, 'time', begin, end, [(group, inside)])


def significant_cells(groups: Sequence[Windows]) -> list[tuple[Cell, CellTest]]:
    """
    Return the significant cells of significant regimes with their tests.

    The p-value of a regime is the least one of its cells, adjusted (R. J. Simes, Biometrika 73
    (1986) 751). The rate for the cells of each is less where few regimes are significant.
    """
    candidates = list(cells(groups))
    tests = zip(candidates, cell_tests(candidates), strict=True)
    regimes = [list(pairs) for _, pairs in groupby(tests, key=lambda pair: pair[0].place)]
    if not regimes:
        return []
    rates = [false_discovery_control([test.p_value for _, test in pairs]) for pairs in regimes]
    significant = false_discovery_control([each.min() for each in rates]) < FALSE_DISCOVERY_RATE
    level = FALSE_DISCOVERY_RATE * float(significant.mean())
    found = zip(chain(*regimes), np.concatenate(rates), strict=True)
    return [pair for pair, rate in found if rate < level]


def localise(groups: Sequence[Windows]) -> list[SignificantResidual]:
    """Return the regimes with significant residuals, the most significant first."""
    regimes = groupby(significant_cells(groups), key=lambda pair: pair[0].place)
    residuals = [_described(list(significant)) for _, significant in regimes]
    return sorted(residuals, key=lambda residual: residual.p_value)


def _described(significant: Sequence[tuple[Cell, CellTest]]) -> SignificantResidual:
    """Return a regime with these significant cells."""
    ranked = sorted(significant, key=lambda pair: pair[1].p_value)
    cell, test = ranked[0]
    spans = [
        (each.members[0][0].recording, float(each.low or 0.0), float(each.high or 0.0))
        for each, _ in significant
        if each.variable == 'time'
    ]
    parts = [
        (each.variable, float(each.low or 0.0), float(each.high or 0.0))
        for each, _ in ranked
        if each.variable in VARIABLES
    ]
    names = dict.fromkeys(g.recording for each, _ in significant for g, _ in each.members)
    bounds = cell.variable, cell.low, cell.high
    unit = STOP_UNIT if cell.members[0][0].at_stops else UNITS[cell.place[0]]
    values = test.mean, test.deviation, test.p_value
    found = tuple(names), tuple(spans), tuple(parts)
    return SignificantResidual(*cell.place, unit, *values, *bounds, *found)
