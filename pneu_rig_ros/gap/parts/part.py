"""
The file that describes a part of a rig, and the part as a hypothesis.

Sections and keys are those of a rig's configuration, but only what the part needs::

    part: chambers                        # chambers, friction or valves
    cylinder: {cap_area: 0.0127 m^2, ...} # chamber 1 grows with x, chamber 2 shrinks
    gas: {gas_constant: 296.8 J/(kg*K), ...}
    valve: shut                           # or the section of a configuration
    effects: {}
    each_recording: [initial_pressure]    # differs from one recording to the next
    refit:                                # what may be wrong, and within which range
      cylinder.cap_dead_volume: [0.02 m^3, 0.03 m^3]
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.parameters import SECTIONS, Model
from pneu_rig_ros.model.quantity import (
    Quantity,
    read_section,
    specifications,
    unknown,
    write_section,
)
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.rig.yaml_file import read_yaml, to_yaml

CHAMBERS, FRICTION, VALVES = KINDS = ('chambers', 'friction', 'valves')
SHUT = 'shut'
"""In place of the valve section: nothing flows."""
NUISANCES = {
    CHAMBERS: ('initial_pressure',), FRICTION: ('force_offset',), VALVES: ()
}  # fmt: skip
"""Kind of part -> what may differ from one recording to the next."""
NEEDED: dict[str, dict[str, tuple[str, ...]]] = {
    CHAMBERS: {
        'cylinder': ('cap_area', 'rod_area', 'cap_dead_volume', 'rod_dead_volume', 'stroke'),
        'gas': ('supply_temperature', 'heat_capacity_ratio', 'gas_constant'),
    },
    FRICTION: {
        'cylinder': ('cap_area', 'rod_area', 'stroke'),
        'friction': ('model', 'coulomb_force', 'element_stiffness'),
    },
    VALVES: {
        'cylinder': ('cap_area', 'rod_area', 'cap_dead_volume', 'rod_dead_volume', 'stroke'),
        'valve': ('intake_coefficient', 'exhaust_coefficient', 'intake_voltage',
                  'exhaust_voltage'),
        'operation': ('supply_pressure',),
    },
}  # fmt: skip
"""Kind of part -> section -> keys that its file must have."""
UNSAID: dict[str, dict[str, dict[str, Any]]] = {
    CHAMBERS: {'operation': {'load_mass': 1.0}},
    FRICTION: {
        'cylinder': {'cap_dead_volume': 0.1, 'rod_dead_volume': 0.1, 'moving_mass': 1.0},
        'friction': {'viscous_coefficient': 0.0, 'micro_viscous_coefficient': 0.0,
                     'element_limit': (), 'stop_velocity': 5e-4, 'start_velocity': 1e-3,
                     'fluid_time_constant': 0.0},
    },
    VALVES: {},
}  # fmt: skip
"""Kind of part -> what holds where the file says nothing [SI]; the rest is that of cylinder 1."""
KEYS = ('part', 'name', *SECTIONS, 'effects', 'each_recording', 'refit')


@dataclass(frozen=True)
class Part:
    """
    A part of a rig under test.

    :param kind: one of ``KINDS``
    :param name: for a reader
    :param hypothesis: its parameters and effects
    :param shut: whether no valve is connected
    :param each_recording: of ``NUISANCES``, fitted to each recording and no explanation
    :param refit: parameter -> range within which it may be wrong [SI]
    :param said: section -> keys that its file gave
    """

    kind: str
    name: str
    hypothesis: Hypothesis
    shut: bool = False
    each_recording: tuple[str, ...] = ()
    refit: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    said: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def with_hypothesis(self, hypothesis: Hypothesis) -> Part:
        """Return the part with other parameters and effects."""
        return replace(self, hypothesis=hypothesis)

    def to_yaml(self) -> str:
        """Return the text of a file that loads back as this part."""
        data: dict[str, Any] = {'part': self.kind, 'name': self.name}
        refitted: dict[str, list[str]] = {}
        for full in self.refit:
            section, key = full.split('.')
            refitted.setdefault(section, []).append(key)
        for section in SECTIONS:
            written = write_section(getattr(self.hypothesis.model, section))
            keys = [*self.said.get(section, ()), *refitted.get(section, ())]
            if keys:
                data[section] = {key: written[key] for key in dict.fromkeys(keys)}
        if self.shut:
            data['valve'] = SHUT
        effects = self.hypothesis.effects
        data['effects'] = {name: write_section(values) for name, values in effects.items()}
        data['each_recording'] = list(self.each_recording)
        data['refit'] = {
            full: [_quantity(full).format(limit) for limit in limits]
            for full, limits in self.refit.items()
        }
        return to_yaml(data)


def load_part(path: Path | str, kind: str | None = None) -> Part:
    """
    Read the file of a part; a whole rig's configuration does where the kind is given.

    :param kind: one of ``KINDS``; None: the file says it
    :raises RigError: for what is missing, unknown, of a wrong unit or out of range
    """
    data = _data(path)
    if data is None or 'part' not in data:
        if kind is None:
            raise RigError(f'{path}: part: missing, allowed: {", ".join(KINDS)}')
        rig = load_configuration(path)
        said = {name: tuple(specifications(section)) for name, section in SECTIONS.items()}
        return Part(kind, rig.name, Hypothesis(rig.model, dict(rig.effects)), said=said)
    if data['part'] not in KINDS:
        raise RigError(f'{path}: part: {unknown(str(data["part"]), KINDS)}')
    if kind not in (None, data['part']):
        raise RigError(f'{path}: describes {data["part"]}, not {kind}')
    return _read(data, str(path))


def describes_part(path: Path | str) -> bool:
    """Return whether a file describes a part, not a whole rig."""
    data = _data(path)
    return data is not None and 'part' in data


def _data(path: Path | str) -> dict[str, Any] | None:
    """Return the mapping of a YAML file, None where there is no such file."""
    return read_yaml(path) if Path(path).is_file() else None


def _read(data: dict[str, Any], origin: str) -> Part:
    for key in data:
        if key not in KEYS:
            raise RigError(f'{origin}: {unknown(str(key), KEYS)}')
    kind = data['part']
    shut = data.get('valve') == SHUT or (kind == CHAMBERS and 'valve' not in data)
    model = load_configuration('cylinder_1').model
    said: dict[str, tuple[str, ...]] = {}
    for name, section in SECTIONS.items():
        given = data.get(name) or {}
        if name == 'valve' and shut:
            given = {}
        where = f'{origin}: {name}'
        values = _section(section, given, NEEDED[kind].get(name, ()), where)
        said[name] = tuple(values)
        changed = {**_unsaid(kind, name, values), **values}
        model = model._replace(**{name: getattr(model, name)._replace(**changed)})
    return Part(
        kind, str(data.get('name', Path(origin).stem)),
        Hypothesis(model, _effects(data.get('effects'), origin)), shut,
        _nuisances(data.get('each_recording'), kind, origin),
        _refit(data.get('refit'), model, origin), said,
    )  # fmt: skip


def _unsaid(kind: str, name: str, said: Mapping[str, Any]) -> dict[str, Any]:
    """Return the defaults of the fields that a section of the file omits [SI]."""
    unsaid = dict(UNSAID[kind].get(name, {}))
    if 'exhaust_voltage' in said:  # a port that opens from there, not with a jump
        unsaid['exhaust_zero_voltage'] = said['exhaust_voltage']
    return unsaid


def _section(
    section: type[Any], given: object, needed: tuple[str, ...], where: str
) -> dict[str, Any]:
    wanted = specifications(section)
    if not isinstance(given, dict):
        raise RigError(f'{where}: expected a mapping with {", ".join(wanted)}')
    for key in given:
        if key not in wanted:
            raise RigError(f'{where}: {unknown(str(key), wanted)}')
    if missing := [key for key in needed if key not in given]:
        raise RigError(f'{where}: missing {", ".join(missing)}')
    return {key: wanted[key].parse(value, f'{where}.{key}') for key, value in given.items()}


def _effects(data: object, origin: str) -> dict[str, Any]:
    if not isinstance(data, dict | None):
        raise RigError(f'{origin}: effects: expected a mapping of name: {{parameter: value}}')
    return {
        str(name): read_section(
            library.load(str(name), f'{origin}: effects').parameters,
            values,
            f'{origin}: effects.{name}',
        )
        for name, values in (data or {}).items()
    }


def _nuisances(data: object, kind: str, origin: str) -> tuple[str, ...]:
    if not isinstance(data, list | None):
        raise RigError(f'{origin}: each_recording: expected a list of names')
    for name in data or []:
        if name not in NUISANCES[kind]:
            raise RigError(f'{origin}: each_recording: {unknown(str(name), NUISANCES[kind])}')
    return tuple(str(name) for name in data or [])


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
        low, high = (_quantity(full).parse(limit, where) for limit in limits)
        section, key = full.split('.')
        value = getattr(getattr(model, section), key)
        value = sum(value) if isinstance(value, tuple) else value
        if not low <= value <= high or low == high:
            raise RigError(f'{where}: {value:g} is not within {low:g} to {high:g}')
        ranges[full] = (low, high)
    return ranges


def _quantity(full: str) -> Quantity:
    """Return unit and range of a parameter; of an element where it is a list."""
    section, key = full.split('.')
    specification = specifications(SECTIONS[section])[key]
    return cast(Quantity, getattr(specification, 'item', specification))
