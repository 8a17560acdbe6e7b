"""By how much recordings of a system differ from its model, as its file states it."""

from collections.abc import Mapping

from pneu_rig_ros.model.quantity import Quantity, mapping_of

FRICTION_LEVEL = 'friction_level'
REPEATABILITY = {
    'gas_1': Quantity('kg/s', 0.0, 1.0, 'of the gas source of chamber 1'),
    'gas_2': Quantity('kg/s', 0.0, 1.0, 'of the gas source of chamber 2'),
    'force': Quantity('N', 0.0, 1e4, 'of the force while sliding'),
    FRICTION_LEVEL: Quantity('-', 0.0, 1.0, 'of F_c and F_smax from recording to recording'),
    'breakaway_force': Quantity('-', 0.0, 1.0, 'of F_smax from recording to recording'),
    'viscous_coefficient': Quantity('-', 0.0, 1.0, 'of sigma_2 from recording to recording'),
    'supply_pressure': Quantity('-', 0.0, 1.0, 'from recording to recording'),
    'load_mass': Quantity('-', 0.0, 1.0, 'from recording to recording'),
    'position_zero': Quantity('m', 0.0, 1.0, 'from recording to recording'),
    'clock_offset': Quantity('s', 0.0, 1.0, 'of sensors and commands between recordings'),
}
"""Standard deviations: of balances, then of quantities between recordings, '-' of their ratio."""
BALANCES = 'gas_1', 'gas_2', 'force'


def between_recordings(values: Mapping[str, float]) -> dict[str, float]:
    """Return those of some standard deviations that are of quantities, and not of balances."""
    return {name: value for name, value in values.items() if name not in BALANCES}


def read_repeatability(data: object, origin: str) -> dict[str, float]:
    """
    Return name -> standard deviation [SI] of a file.

    :raises RigError: for another name, a wrong unit or a value out of range
    """
    where = f'{origin}: repeatability'
    given = mapping_of({} if data is None else data, REPEATABILITY, where).items()
    return {str(key): REPEATABILITY[key].parse(text, f'{where}.{key}') for key, text in given}


def write_repeatability(values: Mapping[str, float]) -> dict[str, str]:
    """Return the mapping that :func:`read_repeatability` reads back."""
    return {name: REPEATABILITY[name].format(value) for name, value in values.items()}
