"""
What differs from one recording to the next and explains nothing, as the file of a system names it.

``each_recording`` is a list of names, or a mapping of names to standard deviations::

    each_recording: [force_offset]
    each_recording: {clock_offset: 0.3 s, initial_temperature: 30 K}
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.quantity import Quantity, unknown

FORCE_OFFSET, CLOCK_OFFSET, INITIAL_TEMPERATURE = (
    'force_offset', 'clock_offset', 'initial_temperature',
)  # fmt: skip


class Nuisance(NamedTuple):
    """
    An error that is constant in a recording.

    :param quantity: its standard deviation
    :param usual: that where the file gives none [SI]
    """

    quantity: Quantity
    usual: float


NUISANCES = {
    # more than any force of a bench: its zero is not known at all
    FORCE_OFFSET: Nuisance(Quantity('N', 1e-3, 1e6, 'zero of the force of a bench'), 1e4),
    # recorders that are started by hand or exchange packets are some 0.1 s apart
    CLOCK_OFFSET: Nuisance(Quantity('s', 1e-4, 10.0, 'delay of the pressures'), 0.3),
    # filling a chamber, or a stroke in a second, warms or cools its gas by tens of kelvin
    INITIAL_TEMPERATURE: Nuisance(
        Quantity('K', 0.1, 100.0, 'of the gas at the start less that of the walls'), 30.0
    ),
}
"""What may differ from one recording to the next."""


def nuisances(data: object, where: str) -> dict[str, float]:
    """
    Return name -> standard deviation [SI] of what differs from recording to recording.

    :raises RigError: for an unknown name, a wrong unit or a value out of range
    """
    if not isinstance(data, list | dict | None):
        raise RigError(f'{where}: expected a list of names, or a mapping to standard deviations')
    for name in data or ():
        if name not in NUISANCES:
            raise RigError(f'{where}: {unknown(str(name), NUISANCES)}')
    if isinstance(data, dict):
        return {str(name): NUISANCES[name].quantity.parse(text, f'{where}.{name}')
                for name, text in data.items()}  # fmt: skip
    return {str(name): NUISANCES[name].usual for name in data or ()}


def written_nuisances(known: Mapping[str, float]) -> dict[str, str]:
    """Return the mapping that :func:`nuisances` reads back."""
    return {name: NUISANCES[name].quantity.format(value) for name, value in known.items()}
