"""By how much recordings of a system differ from its model: what a good model leaves of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pneu_rig_ros.diagnosis.answer.run_differences import level_spread
from pneu_rig_ros.diagnosis.inputs.system import System
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset
from pneu_rig_ros.diagnosis.residuals.nuisances import FORCE_OFFSET
from pneu_rig_ros.diagnosis.residuals.windows import BREAKAWAY, windows_of
from pneu_rig_ros.rig.repeatability import FRICTION_LEVEL, REPEATABILITY


def repeatability(
    system: System, improved: Hypothesis, datasets: Sequence[Dataset]
) -> dict[str, float]:
    """
    Return balance -> standard deviation of the residuals beyond their noise [unit].

    What the system had before is part of it. Of four recordings and more there is also the spread
    of the level of friction between them.
    """
    groups = [each for data in datasets for each in windows_of(data, improved)]
    deviations = dict(system.repeatability)
    for balance in dict.fromkeys(group.balance for group in groups):
        # breakaways, single numbers, are a group of their own
        own = [g for g in groups if g.balance == balance and set(g.regime) != {BREAKAWAY}]
        if not own:
            continue
        # the zero of a bench is unknown
        offset = balance == 'force' and FORCE_OFFSET in system.each_recording
        left = [g.residual - (g.residual.mean() if offset else 0.0) for g in own]
        squares = np.mean(np.concatenate(left) ** 2)
        noise = np.mean(np.concatenate([group.deviation**2 for group in own]))
        before = deviations.get(balance, 0.0)
        deviations[balance] = float(np.sqrt(before**2 + max(squares - noise, 0.0)))
    if 'force' in deviations:
        runs = [run for data in datasets for run in data.single_runs]
        spread = level_spread(improved, runs)
        both = float(np.hypot(deviations.get(FRICTION_LEVEL, 0.0), spread))
        deviations[FRICTION_LEVEL] = REPEATABILITY[FRICTION_LEVEL].within(both)
    return {name: value for name, value in deviations.items() if value > 0.0}
