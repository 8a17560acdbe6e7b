"""From the controller's command to the voltages on the valves: Eq. 1 through the DAC."""

import math

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.valve import CENTRE_VOLTAGE, FULL_VOLTAGE, control_voltages

DAC_STEP = FULL_VOLTAGE / 4095
"""Step of the 12-bit DAC [V]."""

LARGEST_COMMAND = 1000.0
"""
Largest |u| that a controller can mean [V].

2.5 V open a valve fully, and a stiff controller asks for some hundred, which saturate. More than
this is an overflow or another unit.
"""


def checked_command(u: float) -> float:
    """Return the command u [V]; ValueError unless finite and at most ``LARGEST_COMMAND``."""
    valve_voltages(u)
    if abs(u) > LARGEST_COMMAND:
        limit = f'{LARGEST_COMMAND:g}'
        raise ValueError(f'u is {u:g} V, allowed are -{limit} to {limit} V')
    return u


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


def voltages_of(u: Floats) -> tuple[Floats, Floats]:
    """Return u1, u2 as ``valve_voltages`` for each of many finite u [V], shape (n,) each."""
    saturated = np.clip([CENTRE_VOLTAGE + u, CENTRE_VOLTAGE - u], 0.0, FULL_VOLTAGE)
    voltage_1, voltage_2 = np.round(saturated / DAC_STEP) * DAC_STEP
    return voltage_1, voltage_2
