"""
Screening of candidates by what they add to the modelled rates along the measured run.

No simulation, no local minima by slips: a candidate changes the residuals, and its best strength
is looked for among multiples of that change.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.causes.candidates import Candidate, Explanation
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.cycles import Cycles
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset, loss
from pneu_rig_ros.diagnosis.search.fitting import STEP
from pneu_rig_ros.diagnosis.search.scoring import DECISIVE, LIKELY

SHARES = np.concatenate([[0.02, 0.05], np.linspace(0.1, 1.6, 16), [2.0, 3.0, 5.0, 8.0]])
"""Multiples of a candidate's change of the residuals that are screened [-]."""
WEAK = 0.05
"""Share of a start that is simulated freely [-]: slips come a little earlier or later."""
MULTIPLES = np.geomspace(0.02, 20.0, 31)
"""Multiples of that change that are screened [-]."""


@dataclass(frozen=True)
class Screened:
    """
    A candidate with an estimate of the loss that it leaves.

    :param starts: values from which it is fitted, the best first; several where local minima may
        separate them
    :param loss: expected from the first [-]
    :param shift: by which the other causes are expected to change, as theta, shape (k,)
    """

    candidate: Candidate
    starts: tuple[tuple[float, ...], ...]
    loss: float
    shift: tuple[float, ...]


def screen(
    candidate: Candidate,
    given: Hypothesis,
    dataset: Dataset,
    residual: Floats,
    free: Floats,
    room: tuple[Floats, Floats],
) -> Screened:
    """
    Return the loss that a candidate leaves at the best multiple of the change from each start.

    Simulated cycles do not change in proportion to a cause: there only the starts are compared,
    and the strength that the residuals show by themselves.

    :param residual: without the candidate, of free runs the scaled gaps, shape (n,)
    :param free: change of the residual by each value of the other causes, which are fitted again
        with it, see :func:`changes`, shape (n, k)
    :param room: by how much these may fall and rise within their bounds, shape (k,) each
    """
    if dataset.free_runs is not None:
        return _screen_weak(candidate, given, dataset.free_runs, residual, len(free.T))
    simulated = dataset.cycles is not None
    shares = np.ones(1) if simulated else SHARES
    starts = candidate.starts
    if simulated:
        starts = (*_shown_by_residuals(candidate, given, dataset.without_cycles, room), *starts)
    inverse = np.linalg.pinv(free, rcond=STEP)

    def best_share(start: tuple[float, ...]) -> tuple[float, tuple[float, ...], Floats]:
        change = dataset.residual(candidate.apply(given, start)) - residual
        left = [residual + share * change for share in shares]
        shifts = [np.clip(-inverse @ each, *room) for each in left]
        losses = [loss(each + free @ shift) for each, shift in zip(left, shifts, strict=True)]
        best = int(np.argmin(losses))
        return losses[best], candidate.amplified(start, float(shares[best])), shifts[best]

    results = sorted(map(best_share, starts), key=lambda result: result[0])
    if not simulated:  # again, from about as strong as it is, where the change is another
        results.insert(0, min(results[0], best_share(results[0][1]), key=lambda each: each[0]))
    count = 2 if simulated and len(candidate.coordinates) > 1 else 1
    least, _, shift = results[0]
    values = tuple(values for _, values, _ in results[:count])
    return Screened(candidate, values, least, tuple(shift.tolist()))


def _screen_weak(
    candidate: Candidate, given: Hypothesis, cycles: Cycles, gaps: Floats, others: int
) -> Screened:
    """Return the loss that a weak cause leaves in free runs, while the others stay as they are."""

    def best_multiple(values: tuple[float, ...]) -> tuple[float, tuple[float, ...]]:
        change = cycles.gaps(candidate.apply(given, values)) - gaps
        losses = [cycles.loss_of(gaps + multiple * change) for multiple in MULTIPLES]
        best = int(np.argmin(losses))
        return losses[best], candidate.amplified(values, float(MULTIPLES[best]))

    starts = (candidate.amplified(start, WEAK) for start in _directions(candidate))
    _, values = min(map(best_multiple, starts))
    left, values = best_multiple(values)  # again, from about as strong as it is
    return Screened(candidate, (values,), left, (0.0,) * others)


def _directions(candidate: Candidate) -> list[tuple[float, ...]]:
    """Return the starts, of a single value one on each side: weak ones differ by a factor."""
    if len(candidate.coordinates) > 1:
        return list(candidate.starts)
    null = candidate.coordinates[0].null
    return list({start[0] > null: start for start in candidate.starts}.values())


def _shown_by_residuals(
    candidate: Candidate, given: Hypothesis, dataset: Dataset, room: tuple[Floats, Floats]
) -> tuple[tuple[float, ...], ...]:
    """Return the values of a candidate by the residuals alone, none where it gains too little."""
    residual = dataset.residual(given)
    others = np.zeros((residual.size, room[0].size))  # stay as they are
    found = screen(candidate, given, dataset, residual, others, room)
    return found.starts if found.loss < loss(residual) - LIKELY else ()


def starts_of(
    base: Explanation, screened: Sequence[Screened], first: int, end: int
) -> list[Explanation]:
    """
    Return an explanation with each candidate of some names in their order, from all its starts.

    An effect is a candidate under every reading of its law.
    """
    names = list(dict.fromkeys(result.candidate.name for result in screened))[first:end]
    return [
        base.with_theta(base.theta + result.shift).with_part(result.candidate, values)
        for result in screened
        if result.candidate.name in names
        for values in result.starts
    ]


def worth_a_fit(screened: Sequence[Screened], loss_without: float, windows: int) -> list[Screened]:
    """
    Return the candidates that would gain decisively if each kept to its estimate.

    A score test: what a cause adds to each window is known from its formula, so that its gain sums
    over all of them (C. R. Rao, Proc. Camb. Phil. Soc. 44 (1948) 50).
    """
    price = 0.5 * np.log(max(windows, 1))
    return [
        result
        for result in screened
        if loss_without - result.loss > DECISIVE + price * len(result.candidate.coordinates)
    ]


def changes(explanation: Explanation, dataset: Dataset) -> Floats:
    """Return the derivative of the residual by each value of an explanation, shape (n, k)."""
    base, theta = dataset.residual(explanation.hypothesis), explanation.theta
    columns = np.zeros((base.size, theta.size))
    for index, step in enumerate(STEP * np.eye(theta.size)):
        moved = explanation.with_theta(theta + step)
        columns[:, index] = (dataset.residual(moved.hypothesis) - base) / STEP
    return columns
