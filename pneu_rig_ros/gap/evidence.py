"""The experiments that a diagnosis looks at, and the gap of a hypothesis on them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.gap.experiment import Experiment
from pneu_rig_ros.gap.floors import noise_floor
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode, gap

Floats = NDArray[np.float64]

COLUMNS = {Mode.CHAMBERS: (1, 2), Mode.CYCLES: (0, 1, 2), Mode.FREE: (0, 1, 2)}
"""Columns of a gap, x, p1, p2, that a prediction says something of."""


@dataclass
class Evidence:
    """
    Experiments, with the noise floors of their predictions.

    :param experiments: the measured runs
    :param rng: source of the errors that are propagated
    """

    experiments: Sequence[Experiment]
    rng: np.random.Generator
    floors: dict[Mode, list[Floats]] = field(default_factory=dict)

    def settle_floors(self, hypothesis: Hypothesis, modes: Iterable[Mode]) -> None:
        """Propagate the errors of the readings under a hypothesis."""
        for mode in modes:
            self.floors[mode] = [
                noise_floor(hypothesis, experiment, mode, self.rng)
                for experiment in self.experiments
            ]

    def gaps(self, hypothesis: Hypothesis, mode: Mode) -> list[Floats]:
        """Return the gap of each experiment in noise floors, shape (blocks, columns) each."""
        columns = list(COLUMNS[mode])

        def one(pair: tuple[Experiment, Floats]) -> Floats:
            experiment, floor = pair
            difference = gap(hypothesis, experiment, mode)
            scaled: Floats = (difference / floor)[:, columns]
            return np.nan_to_num(scaled, nan=1e6, posinf=1e6, neginf=-1e6)

        return [one(pair) for pair in zip(self.experiments, self.floors[mode], strict=True)]

    def residual(self, hypothesis: Hypothesis, modes: Sequence[Mode]) -> Floats:
        """
        Return what a fit makes small, shape (n,): its mean square is :meth:`cost`.

        The inverse hyperbolic sine of the gap in noise floors: linear within the noise, while a
        slip that comes at another time does not outweigh everything else.
        """
        parts = []
        for mode in modes:
            every = np.concatenate([g.ravel() for g in self.gaps(hypothesis, mode)])
            parts.append(np.arcsinh(every) / np.sqrt(every.size))
        every_mode: Floats = np.concatenate(parts) / np.sqrt(len(modes))
        return every_mode

    def cost(self, hypothesis: Hypothesis, modes: Sequence[Mode]) -> float:
        """Return the mean square of the residual [-], about 0.6 at the noise floor."""
        return float(np.sum(self.residual(hypothesis, modes) ** 2))

    def subset(self, indices: Sequence[int]) -> Evidence:
        """Return some of the experiments, with their floors."""
        floors = {mode: [every[i] for i in indices] for mode, every in self.floors.items()}
        chosen = [self.experiments[i] for i in indices]
        return Evidence(chosen, self.rng, floors)
