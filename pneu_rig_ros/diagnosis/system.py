"""
The system under test: a rig, or whatever part of one a file describes and a recording shows.

Sections and keys are those of a rig's configuration, but only what is known::

    name: sealed_chambers
    cylinder: {cap_area: 0.0127 m^2, cap_dead_volume: 0.025 m^3, ...}
    gas: {gas_constant: 296.8 J/(kg*K), ...}
    valve: shut                           # or the section of a configuration
    fixed: {position: 0 m}                # does not move, and is not recorded
    each_recording: [force_offset]        # differs, see ``nuisances``
    refit:                                # what may be wrong, and within which range
      cylinder.cap_dead_volume: [0.02 m^3, 0.03 m^3]

A balance is open when its signals are recorded and the file has the sections it needs.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.nuisances import nuisances, written_nuisances
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.parameters import SECTIONS, Model
from pneu_rig_ros.model.quantity import (
    Quantity,
    read_section,
    specifications,
    unknown,
    write_section,
)
from pneu_rig_ros.model.shape import read_effect, write_effect
from pneu_rig_ros.records.recording import Recording
from pneu_rig_ros.rig import RigConfiguration, load_configuration
from pneu_rig_ros.rig.sensors import Sensors
from pneu_rig_ros.rig.yaml_file import read_yaml, to_yaml

SHUT = 'shut'
"""In place of the valve section: nothing flows."""
OWN_KEYS = ('fixed', 'each_recording', 'refit')
"""Keys that a rig's configuration does not have."""
FIXED = {
    'position': Quantity('m', 0.0, 10.0, 'of a piston that does not move'),
    'pressure_1': Quantity('Pa', 5e4, 1.1e6, 'of a chamber that is held at it'),
    'pressure_2': Quantity('Pa', 5e4, 1.1e6, 'of a chamber that is held at it'),
}
"""Signals that may be constant and not recorded."""
GAS_KEYS = ('supply_temperature', 'heat_capacity_ratio', 'gas_constant')
VALVE_KEYS = ('intake_coefficient', 'exhaust_coefficient', 'intake_voltage', 'exhaust_voltage')
FRICTION_KEYS = ('model', 'coulomb_force', 'element_stiffness')
UNUSED: dict[str, dict[str, Any]] = {
    'cylinder': {'cap_area': 1e-3, 'rod_area': 1e-3, 'cap_dead_volume': 0.1,
                 'rod_dead_volume': 0.1, 'stroke': 10.0, 'moving_mass': 1.0},
    'friction': {'model': 0, 'breakaway_force': 1e5, 'coulomb_force': 1e5,
                 'viscous_coefficient': 0.0, 'micro_viscous_coefficient': 0.0,
                 'element_stiffness': (1e6,), 'element_limit': (), 'stop_velocity': 5e-4,
                 'start_velocity': 1e-3, 'fluid_time_constant': 0.0},
    'operation': {'supply_pressure': 1.1e6, 'load_mass': 0.0, 'rest_time': 0.0},
}  # fmt: skip
"""
Section -> what stands where a file says nothing [SI]. No open balance uses any of it: without its
own keys a balance is closed.
"""
GAS_1, GAS_2, FORCE = BALANCES = ('gas_1', 'gas_2', 'force')


@dataclass(frozen=True)
class System:
    """
    What is known of the system.

    :param name: for a reader
    :param hypothesis: its parameters and effects
    :param said: section -> keys that its file gave
    :param sensors: of a rig, None where they are not known
    :param shut: whether no valve is connected
    :param fixed: signal -> constant value [SI]
    :param each_recording: nuisance -> its standard deviation [SI]
    :param refit: parameter -> range within which it may be wrong [SI]
    :param rig: the configuration, None for what is no whole rig
    """

    name: str
    hypothesis: Hypothesis
    said: Mapping[str, tuple[str, ...]]
    sensors: Sensors | None = None
    shut: bool = False
    fixed: Mapping[str, float] = field(default_factory=dict)
    each_recording: Mapping[str, float] = field(default_factory=dict)
    refit: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    rig: RigConfiguration | None = None

    def closed(self, recording: Recording) -> dict[str, str]:
        """Return balance -> what is missing for it in a file or recording, '' where it is open."""
        return {
            GAS_1: ', '.join(self._missing_gas(recording, 1)),
            GAS_2: ', '.join(self._missing_gas(recording, 2)),
            FORCE: ', '.join(self._missing_force(recording)),
        }

    def _missing_gas(self, recording: Recording, chamber: int) -> list[str]:
        prefix = 'cap' if chamber == 1 else 'rod'
        keys = [f'{prefix}_dead_volume']
        if 'position' not in self.fixed:
            keys += [f'{prefix}_area', *(['stroke'] if chamber == 2 else [])]
        missing = self._unsaid('cylinder', keys) + self._unsaid('gas', GAS_KEYS)
        if not self.shut:
            missing += self._unsaid('valve', VALVE_KEYS)
            if 'supply_pressure' not in recording.conditions:
                missing += self._unsaid('operation', ['supply_pressure'])
            missing += [] if recording.driven else ['signal u']
        return missing + self._unrecorded(recording, 'position', f'pressure_{chamber}')

    def _missing_force(self, recording: Recording) -> list[str]:
        missing = self._unsaid('cylinder', ['cap_area', 'rod_area', 'stroke'])
        missing += self._unsaid('friction', FRICTION_KEYS)
        if on_bench(recording):
            pressures = [f'pressure_{i}' for i in (1, 2)]
            if not any(one in recording or one in self.fixed for one in pressures):
                missing += ['signal pressure_1 or pressure_2']
            return missing + self._unrecorded(recording, 'position')
        missing += self._unsaid('cylinder', ['moving_mass'])
        return missing + self._unrecorded(recording, 'position', 'pressure_1', 'pressure_2')

    def _unsaid(self, section: str, keys: Any) -> list[str]:
        said = self.said.get(section, ())
        return [f'{section}.{key}' for key in keys if key not in said]

    def _unrecorded(self, recording: Recording, *signals: str) -> list[str]:
        return [f'signal {one}' for one in signals
                if one not in recording and one not in self.fixed]  # fmt: skip

    def to_yaml(self, hypothesis: Hypothesis) -> str:
        """Return the text of a file that loads back as this system under a hypothesis."""
        if self.rig is not None:
            effects = dict(hypothesis.effects)
            return replace(self.rig, model=hypothesis.model, effects=effects).to_yaml()
        data: dict[str, Any] = {'name': self.name}
        for section in SECTIONS:
            written = write_section(getattr(hypothesis.model, section))
            changed = [full.split('.')[1] for full in self.refit if full.startswith(section)]
            keys = dict.fromkeys([*self.said.get(section, ()), *changed])
            if keys:
                data[section] = {key: written[key] for key in keys}
        if self.shut:
            data['valve'] = SHUT
        if self.sensors is not None:
            data['sensors'] = write_section(self.sensors)
        data['effects'] = {name: write_effect(own) for name, own in hypothesis.effects.items()}
        data['fixed'] = {name: FIXED[name].format(value) for name, value in self.fixed.items()}
        data['each_recording'] = written_nuisances(self.each_recording)
        data['refit'] = {full: [quantity_of(full).format(limit) for limit in limits]
                         for full, limits in self.refit.items()}  # fmt: skip
        return to_yaml(data)


def on_bench(recording: Recording) -> bool:
    """Return whether a bench moves the piston and says with which force."""
    return 'force' in recording


def load_system(source: Path | str) -> System:
    """
    Read the file of a system; the name of a shipped cylinder does.

    :raises RigError: for what is missing, unknown, of a wrong unit or out of range
    """
    data = read_yaml(source) if Path(source).is_file() else None
    if data is None or _is_rig(data):
        rig = load_configuration(source)
        said = {name: tuple(specifications(section)) for name, section in SECTIONS.items()}
        hypothesis = Hypothesis(rig.model, dict(rig.effects))
        return System(rig.name, hypothesis, said, rig.sensors, rig=rig)
    return _read(data, str(source))


def _is_rig(data: object) -> bool:
    """Return whether a file describes a whole rig: cylinder and friction, and no key of a part."""
    if not isinstance(data, dict):
        return True  # what is wrong with it the configuration says
    whole = isinstance(data.get('friction'), dict) and isinstance(data.get('cylinder'), dict)
    complete = whole and all(
        set(specifications(SECTIONS[name])) <= set(data[name]) for name in ('cylinder', 'friction')
    )
    partial = any(key in data for key in OWN_KEYS) or data.get('valve') == SHUT
    return complete and not partial


def _read(data: dict[str, Any], origin: str) -> System:
    keys = ('name', *SECTIONS, 'effects', 'sensors', *OWN_KEYS)
    for key in data:
        if key not in keys:
            raise RigError(f'{origin}: {unknown(str(key), keys)}')
    shut = data.get('valve') == SHUT
    model, said = load_configuration('cylinder_1').model, {}
    for name, section in SECTIONS.items():
        given = {} if name == 'valve' and shut else data.get(name) or {}
        values = _section(section, given, f'{origin}: {name}')
        said[name] = tuple(values)
        unused = dict(UNUSED.get(name, {}))
        if 'exhaust_voltage' in values:  # a port that opens from there, not with a jump
            unused['exhaust_zero_voltage'] = values['exhaust_voltage']
        changed = getattr(model, name)._replace(**{**unused, **values})
        model = model._replace(**{name: changed})
    return System(
        str(data.get('name', Path(origin).stem)),
        Hypothesis(model, _effects(data.get('effects'), origin)), said,
        _sensors(data.get('sensors'), origin), shut,
        _fixed(data.get('fixed'), origin),
        nuisances(data.get('each_recording'), f'{origin}: each_recording'),
        _refit(data.get('refit'), model, origin),
    )  # fmt: skip


def _section(section: type[Any], given: object, where: str) -> dict[str, Any]:
    wanted = specifications(section)
    if not isinstance(given, dict):
        raise RigError(f'{where}: expected a mapping with {", ".join(wanted)}')
    for key in given:
        if key not in wanted:
            raise RigError(f'{where}: {unknown(str(key), wanted)}')
    return {key: wanted[key].parse(value, f'{where}.{key}') for key, value in given.items()}


def _sensors(data: object, origin: str) -> Sensors | None:
    """Return the data sheet of the sensors, None without one."""
    if data is None:
        return None
    return cast(Sensors, read_section(Sensors, data, f'{origin}: sensors'))


def _effects(data: object, origin: str) -> dict[str, Any]:
    if not isinstance(data, dict | None):
        raise RigError(f'{origin}: effects: expected a mapping of name: {{parameter: value}}')
    return {
        str(name): read_effect(library.load(str(name), f'{origin}: effects'), values,
                               f'{origin}: effects.{name}')
        for name, values in (data or {}).items()
    }  # fmt: skip


def _fixed(data: object, origin: str) -> dict[str, float]:
    if not isinstance(data, dict | None):
        raise RigError(f'{origin}: fixed: expected a mapping with {", ".join(FIXED)}')
    for name in data or {}:
        if name not in FIXED:
            raise RigError(f'{origin}: fixed: {unknown(str(name), FIXED)}')
    return {str(name): FIXED[name].parse(value, f'{origin}: fixed.{name}')
            for name, value in (data or {}).items()}  # fmt: skip


def _refit(data: object, model: Model, origin: str) -> dict[str, tuple[float, float]]:
    """Return parameter -> range; RigError for an unknown one or a range without the value."""
    if not isinstance(data, dict | None):
        raise RigError(f'{origin}: refit: expected a mapping of section.name: [low, high]')
    allowed = [f'{name}.{key}' for name, section in SECTIONS.items()
               for key, spec in specifications(section).items()
               if isinstance(getattr(spec, 'item', spec), Quantity)]  # fmt: skip
    ranges = {}
    for full, limits in (data or {}).items():
        where = f'{origin}: refit.{full}'
        if full not in allowed:
            raise RigError(f'{origin}: refit: {unknown(str(full), allowed)}')
        if not isinstance(limits, list) or len(limits) != 2:
            raise RigError(f'{where}: expected [low, high]')
        low, high = (quantity_of(full).parse(limit, where) for limit in limits)
        value = value_of(model, full)
        if not low <= value <= high or low == high:
            raise RigError(f'{where}: {value:g} is not within {low:g} to {high:g}')
        ranges[full] = (low, high)
    return ranges


def value_of(model: Model, full: str) -> float:
    """Return a parameter 'section.name' [SI]; the sum of one that is a list."""
    section, key = full.split('.')
    value = getattr(getattr(model, section), key)
    return float(sum(value)) if isinstance(value, tuple) else float(value)


def quantity_of(full: str) -> Quantity:
    """Return unit and range of a parameter; of an element where it is a list."""
    section, key = full.split('.')
    specification = specifications(SECTIONS[section])[key]
    return cast(Quantity, getattr(specification, 'item', specification))
