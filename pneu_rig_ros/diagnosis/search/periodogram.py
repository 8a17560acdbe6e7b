"""Waves over the position in what is left of the force: a detent, a thread, cogging."""

from collections.abc import Sequence

import numpy as np
from scipy.signal import lombscargle

from pneu_rig_ros.diagnosis.residuals.windows import SLIDING, Windows

SHORTEST = 4e-3
"""Shortest wavelength [m]: windows of 70 ms average over as much at 60 mm/s."""
STEP = 0.25
"""Of the number of waves in the covered positions, an oversampled grid [-]."""


def dominant_wavelengths(groups: Sequence[Windows]) -> list[float]:
    """
    Return the wavelength that explains most of the force while the piston slides [m].

    By a periodogram of the residuals, weighted by their noise (M. Zechmeister, M. Kuerster,
    Astron. Astrophys. 496 (2009) 577); none where the windows cover less than two waves.
    """
    columns = [
        np.column_stack([group.variables['position'], group.residual, group.deviation])[
            group.regime == SLIDING
        ]
        for group in groups
        if group.balance == 'force'
    ]
    position, residual, deviation = np.concatenate([*columns, np.zeros((0, 3))]).T
    span = float(np.ptp(position)) if position.size else 0.0
    if span < 2.0 * SHORTEST:
        return []
    waves = np.arange(1.0, span / SHORTEST, STEP) / span
    angular = 2.0 * np.pi * waves
    weights = deviation**-2
    power = lombscargle(position, residual, angular, weights=weights, floating_mean=True)
    return [1.0 / float(waves[np.argmax(power)])]
