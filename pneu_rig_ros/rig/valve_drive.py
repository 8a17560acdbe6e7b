"""From the controller's command to the voltages on the valves: Eq. 1 through the DAC."""

import math

from pneu_rig_ros.model.valve import FULL_VOLTAGE, control_voltages

DAC_STEP = FULL_VOLTAGE / 4095
"""Step of the 12-bit DAC [V]."""


def valve_voltages(u: float) -> tuple[float, float]:
    """
    Return u1, u2 [V] for the command u [V]: Eq. 1, saturated to 0-5 V, in steps of the DAC.

    :raises ValueError: unless u is finite
    """
    if not math.isfinite(u):
        raise ValueError(f'u is {u}, allowed are finite voltages')
    voltage_1, voltage_2 = control_voltages(u)
    return _dac(voltage_1), _dac(voltage_2)


def _dac(voltage: float) -> float:
    saturated = min(max(voltage, 0.0), FULL_VOLTAGE)
    return round(saturated / DAC_STEP) * DAC_STEP
