"""
Checks that signals are physically possible: a wrong unit is off by a factor.

Impossible values would make the simulation take ever smaller steps, and a diagnosis meaningless.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.rig import RigConfiguration

Floats = NDArray[np.float64]

BEYOND = 0.25
"""How far beyond the end stops a position may be, as a share of the stroke [-]."""
LEAST, MOST = 0.5, 5.0
"""Of absolute pressures: in pressures of the surroundings, and of the supply [-]."""


def check_plausible(
    origin: object, signals: Mapping[str, Floats], configuration: RigConfiguration
) -> None:
    """
    Check that position [m] and absolute pressures [Pa] can be those of a rig.

    :param origin: their name in errors
    :param signals: name -> values, shape (n,), NaN for missing values
    :param configuration: the rig under the conditions of the run
    :raises RigError: when one is out of range, with a likely reason
    """
    model = configuration.model
    stroke, supply = model.cylinder.stroke, model.operation.supply_pressure
    within = -BEYOND * stroke, (1.0 + BEYOND) * stroke, 'm', 'that of another cylinder'
    absolute = LEAST * model.gas.atmospheric_pressure, MOST * supply, 'Pa', 'a gauge pressure'
    allowed = {'position': within, 'pressure_1': absolute, 'pressure_2': absolute}
    for name, (low, high, unit, reason) in allowed.items():
        values = signals.get(name, np.empty(0))
        values = values[np.isfinite(values)]
        if values.size and not (low <= values.min() and values.max() <= high):
            raise RigError(
                f'{origin}: {name} from {values.min():.4g} to {values.max():.4g} {unit}, '
                f'{configuration.name} allows {low:.4g} to {high:.4g} {unit}; '
                f'is it in another unit, or {reason}?'
            )
