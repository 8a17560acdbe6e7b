"""
Which balances of a recording are open, and what is missing to compare the others.

A balance needs values of the system's file, 'section.key', and signals, 'signal name', that are
recorded or constant.
"""

from collections.abc import Iterator

from pneu_rig_ros.diagnosis.inputs.system import System
from pneu_rig_ros.records.recording import Recording


def on_bench(recording: Recording) -> bool:
    """Return whether a bench moves the piston and records its force."""
    return 'force' in recording


def lacks(system: System, recording: Recording) -> dict[str, str]:
    """Return balance -> what a file or recording lacks for it, '' where it is open."""
    needs = {
        'gas_1': _of_gas(system, 'cap', 1),
        'gas_2': _of_gas(system, 'rod', 2),
        'force': _of_force(on_bench(recording)),
    }
    return {
        balance: ', '.join(need for need in each if not _known(need, system, recording))
        for balance, each in needs.items()
    }


def _of_gas(system: System, side: str, chamber: int) -> Iterator[str]:
    yield f'cylinder.{side}_dead_volume'
    if 'position' not in system.fixed:
        yield f'cylinder.{side}_area'
        if chamber == 2:
            yield 'cylinder.stroke'
    yield from ('gas.supply_temperature', 'gas.heat_capacity_ratio', 'gas.gas_constant')
    if not system.shut:
        yield from ('valve.intake_coefficient', 'valve.exhaust_coefficient')
        yield from ('valve.intake_voltage', 'valve.exhaust_voltage')
        yield from ('operation.supply_pressure', 'signal u')
    yield from ('signal position', f'signal pressure_{chamber}')


def _of_force(bench: bool) -> Iterator[str]:
    yield from ('cylinder.cap_area', 'cylinder.rod_area', 'cylinder.stroke')
    yield from ('friction.model', 'friction.coulomb_force', 'friction.element_stiffness')
    if bench:
        yield from ('signal pressure_1 or pressure_2', 'signal position')
    else:
        yield 'cylinder.moving_mass'
        yield from ('signal position', 'signal pressure_1', 'signal pressure_2')


def _known(need: str, system: System, recording: Recording) -> bool:
    if need == 'signal u':
        return recording.driven
    if need.startswith('signal '):
        names = need.removeprefix('signal ').split(' or ')
        return any(name in recording or name in system.fixed for name in names)
    section, key = need.split('.')
    stated = section == 'operation' and key in recording.conditions
    return stated or key in system.given.get(section, ())
