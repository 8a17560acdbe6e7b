"""What a latent input depends on: signals whose parts explain much of it, or are significant."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import block_diag, spmatrix

from pneu_rig_ros.arrays import Floats, Indices
from pneu_rig_ros.diagnosis.residuals.latent import Latent, smooth
from pneu_rig_ros.diagnosis.residuals.localisation import LEAST_WIDTH, SignificantResidual
from pneu_rig_ros.diagnosis.residuals.windows import BREAKAWAY, VARIABLES, Windows
from pneu_rig_ros.report.figure import BLUE, ORANGE

COLOURS = {'out': BLUE, 'in': ORANGE, '': '#5f6570'}
NAMES = {'out': 'outstroke', 'in': 'instroke', '': 'at rest'}
"""Direction -> colour, name."""
SYMBOLS = {
    'position': 'position x',
    'velocity': 'velocity v',
    'pressure_1': 'pressure $p_1$',
    'pressure_2': 'pressure $p_2$',
    'time': 'time',
    'dwell': 'rest before',
}
BINS = 9
"""Parts into which the range of a signal is divided in each direction, by quantiles."""
FEW_BINS = 3
"""The same where there are few values."""
SPANS = {**LEAST_WIDTH, 'time': 0.5}
"""Least width of a part [SI]."""
FEWEST = 3
"""Values of a part at least."""
LEAD = 0.1
"""Time has to explain so much more than any signal to be chosen: all change with it [-]."""
DECADES = 8.0
"""Largest in smallest rest from which on the axis is logarithmic [-]."""


class Bins(NamedTuple):
    """Means over the parts of a range with their standard deviations, in one direction."""

    middle: Floats
    mean: Floats
    deviation: Floats


@dataclass(frozen=True)
class Track:
    """
    The latent input of a balance in one recording.

    :param windows: with a hypothesis
    :param explained: what the explanation contributes to each window [unit], None without one
    :param breakaways: of the piston, for the force
    :param duration: of the recording [s]
    """

    windows: Windows | None
    explained: Floats | None
    breakaways: Windows | None
    name: str
    duration: float

    @cached_property
    def latent(self) -> Latent | None:
        """The latent input, None where no window says anything."""
        return None if self.windows is None else smooth(self.windows)


@dataclass(frozen=True)
class Samples:
    """
    Values of one latent input, of a recording or of several one after the other.

    :param values: shape (m,)
    :param covariance: of their errors, shape (m, m); sparse of several recordings
    :param variables: signal -> values, shape (m,), NaN where it has none
    :param direction: of each
    """

    values: Floats
    covariance: Floats | spmatrix
    variables: Mapping[str, Floats]
    direction: NDArray[np.str_]

    def with_values_of(self, name: str) -> Samples:
        """Return the samples in which a signal has a value."""
        known = np.flatnonzero(np.isfinite(self.variables[name]))
        columns = {key: values[known] for key, values in self.variables.items()}
        covariance = self.covariance[known][:, known]
        return Samples(self.values[known], covariance, columns, self.direction[known])


@dataclass(frozen=True)
class Dependence:
    """
    A latent input against one signal.

    :param variable: name of the signal
    :param bins: direction -> what is drawn
    :param joined: whether the points are means that a line may join, not single breakaways
    """

    title: str
    variable: str
    bins: Mapping[str, Bins]
    joined: bool
    logarithmic: bool


def dependence(
    tracks: Sequence[Track], significant: Sequence[SignificantResidual] = ()
) -> list[Dependence]:
    """
    Return what the latent input depends on, and what it does at breakaways if there are any.

    Each against the signal that explains most, and against the one with the most significant part.

    :param significant: residuals of the balance
    """
    moving = [
        _moving(one.windows, one.latent)
        for one in tracks
        if one.windows is not None and one.latent is not None
    ]
    breaks = [_breaking(one.breakaways) for one in tracks if one.breakaways is not None]
    sides = []
    for recordings, title, bins in (moving, 'all recordings', BINS), (breaks, 'breakaways', 0):
        if recordings:
            samples = _joined(recordings)
            most = most_significant_signal(significant, not bins)
            sides += [_against(samples, name, title, bins) for name in _names(samples, most, bins)]
    return [side for side in sides if side is not None]


def at_breakaways(residual: SignificantResidual) -> bool:
    """Return whether a residual is drawn with the breakaways, which only the force has apart."""
    return (residual.balance, residual.regime) == ('force', BREAKAWAY)


def most_significant_signal(significant: Sequence[SignificantResidual], breaks: bool) -> str:
    """Return the signal with the most significant part, of breakaways or others; '' if none is."""
    parts = (part for one in significant if at_breakaways(one) == breaks for part in one.parts[:1])
    return next((name for name, _, _ in parts), '')


def _moving(windows: Windows, latent: Latent) -> Samples:
    variables = {name: latent.average @ windows.variables[name] for name in VARIABLES}
    variables['time'] = latent.time
    return Samples(latent.cleared, latent.covariance, variables, latent.direction)


def _breaking(breaks: Windows) -> Samples:
    variables = {name: breaks.variables[name] for name in VARIABLES if name != 'velocity'}
    variables['time'] = breaks.middle
    covariance = np.diag(breaks.deviation**2)
    return Samples(breaks.residual, covariance, variables, breaks.direction)


def _joined(samples: Sequence[Samples]) -> Samples:
    names = samples[0].variables
    return Samples(
        np.concatenate([one.values for one in samples]),
        block_diag([one.covariance for one in samples], format='csr'),
        {name: np.concatenate([one.variables[name] for one in samples]) for name in names},
        np.concatenate([one.direction for one in samples]),
    )


def _names(samples: Samples, significant: str, bins: int) -> list[str]:
    """Return the signals against which samples are drawn, the one that explains most first."""
    everywhere = [name for name, values in samples.variables.items() if np.isfinite(values).all()]
    shares = {name: explained(samples, name, bins or FEW_BINS) for name in everywhere}
    # Every signal changes with time, so time must explain clearly more to be chosen.
    best = max(shares, key=lambda key: shares[key] - (LEAD if key == 'time' else 0.0))
    return [best, significant] if significant in {*samples.variables} - {best} else [best]


def _against(samples: Samples, name: str, title: str, bins: int) -> Dependence | None:
    """Return the samples against a signal; unbinned for ``bins`` of 0."""
    if not np.isfinite(samples.variables[name]).all():
        samples, title = samples.with_values_of(name), 'at rest'
    directions = [direction for direction in COLOURS if direction in samples.direction]
    rows = {direction: binned(samples, name, direction, bins) for direction in directions}
    filled = {direction: row for direction, row in rows.items() if row.middle.size}
    if bins and all(row.middle.size < 2 for row in filled.values()):
        return None  # nothing that it could depend on varies
    values = samples.variables[name]
    wide = name == 'dwell' and values.max() > DECADES * values.min() > 0.0
    if bins and (share := explained(samples, name, bins)) >= 0.01:
        title += f'\n{share:.0%} of the variance'
    return Dependence(title, name, filled, bins > 0, bool(wide))


def explained(samples: Samples, name: str, bins: int) -> float:
    """Return the share of the variance that bins of a signal explain, for their number [-]."""
    values = np.clip(samples.values, *np.percentile(samples.values, [1.0, 99.0]))
    weights = 1.0 / samples.covariance.diagonal()
    kinds, groups = np.unique(part_numbers(samples, name, bins), return_inverse=True)
    if kinds.size >= values.size - 1:
        return 0.0
    sums = np.bincount(groups, weights)
    means = np.bincount(groups, weights * values) / sums
    total = float(np.sum(weights * (values - np.average(values, weights=weights)) ** 2))
    within = float(np.sum(weights * (values - means[groups]) ** 2))
    freedom = (values.size - 1) / (values.size - kinds.size)
    return max(1.0 - freedom * within / total, 0.0) if total > 0.0 else 0.0


def part_numbers(samples: Samples, name: str, bins: int) -> Indices:
    """Return the part of the range of a signal that each value is in, of its direction alone."""
    column = samples.variables[name]
    numbers = np.zeros(column.size, dtype=np.intp)
    for index, direction in enumerate(np.unique(samples.direction)):
        here = samples.direction == direction
        cuts = cuts_of(column[here], name, bins)
        numbers[here] = (bins + 1) * index + np.digitize(column[here], cuts)
    return numbers


def cuts_of(values: Floats, name: str, bins: int) -> Floats:
    """Return what parts the range of a signal: the middles between quantiles that are apart."""
    levels: list[float] = []
    for level in np.quantile(values, np.linspace(0.0, 1.0, bins)):
        if not levels or level - levels[-1] >= SPANS[name]:
            levels.append(float(level))
    cuts: Floats = 0.5 * (np.array(levels[1:]) + np.array(levels[:-1]))
    return cuts


def binned(samples: Samples, name: str, direction: str, bins: int) -> Bins:
    """Return the means over bins of a signal in one direction; the values themselves for 0."""
    column, here = samples.variables[name], samples.direction == direction
    variances = samples.covariance.diagonal()
    if not bins:
        return Bins(column[here], samples.values[here], np.sqrt(variances[here]))
    numbers, rows = part_numbers(samples, name, bins), []
    for number in np.unique(numbers[here]):
        inside = numbers == number
        if inside.sum() >= FEWEST:
            weights = inside / variances
            weights /= weights.sum()
            variance = weights @ (samples.covariance @ weights)
            rows.append((column[inside].mean(), weights @ samples.values, variance**0.5))
    return Bins(*np.array(rows).reshape(-1, 3).T)
