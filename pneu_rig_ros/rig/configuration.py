"""A rig's configuration: read from YAML, checked, overridden, written back."""

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, NamedTuple, cast

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.parameters import FRICTION_MODELS, SECTIONS, Friction, Model, Operation
from pneu_rig_ros.model.quantity import (
    LARGEST_INTEGER,
    Choice,
    Quantity,
    mapping_of,
    read_section,
    read_values,
    specifications,
    unknown,
    write_section,
    write_values,
)
from pneu_rig_ros.model.shape import read_effect, without_shape, write_effect
from pneu_rig_ros.rig.sensors import Sensors
from pneu_rig_ros.rig.yaml_file import configuration_folder, locate, parse_yaml, read_text, to_yaml


class Sampling(NamedTuple):
    """Clock and seed of the data acquisition."""

    interval: Annotated[float, Quantity('ns', 1e5, 1e9, 'sampling interval')]
    seed: Annotated[float, Quantity('-', 0, LARGEST_INTEGER, 'seed of noise and calibration')]


OVERRIDES: dict[str, Quantity] = {
    name: cast(Quantity, specifications(Operation)[name])
    for name in ('supply_pressure', 'load_mass', 'initial_position', 'rest_time')
}
"""Quantities of the set-up that a user may override by name."""

AREA_AGREEMENT = 0.05
"""Largest difference between Table 2's rounded areas and Table 1's diameters [-]."""

LONGEST_NAME = 100
"""Of a rig [character]."""

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
"""
By how much recordings of a system differ from its model, as its file states it.

Standard deviations: of balances, then of quantities between recordings, '-' of their ratio.
"""
_BALANCES = 'gas_1', 'gas_2', 'force'

_ALL_SECTIONS = {**SECTIONS, 'sensors': Sensors, 'sampling': Sampling}


@dataclass(frozen=True)
class RigConfiguration:
    """
    Everything that defines a rig.

    :param name: of the cylinder
    :param effects: name -> parameters of the optional effects, some of them ``Shaped``
    :param seed: of noise and calibration
    :param repeatability: balance -> standard deviation of what the model left of recordings; the
        plant does not use it
    """

    name: str
    model: Model
    effects: dict[str, Any]
    sensors: Sensors
    interval_ns: int
    seed: int
    repeatability: Mapping[str, float] = field(default_factory=dict)

    def to_yaml(self) -> str:
        """Return the complete configuration as YAML that loads back unchanged."""
        sections: dict[str, Any] = {'name': self.name}
        for key in SECTIONS:
            sections[key] = write_section(getattr(self.model, key))
        sections['effects'] = {name: write_effect(own) for name, own in self.effects.items()}
        sections['sensors'] = write_section(self.sensors)
        sections['sampling'] = write_section(Sampling(self.interval_ns, self.seed))
        if self.repeatability:
            sections['repeatability'] = write_values(self.repeatability, REPEATABILITY)
        return to_yaml(sections)

    def with_parameter(self, section: str, key: str, value: Any) -> 'RigConfiguration':
        """Return the rig with another value of a parameter of its model, SI, not checked."""
        changed = getattr(self.model, section)._replace(**{key: value})
        return replace(self, model=self.model._replace(**{section: changed}))

    def geometry(self) -> dict[str, float]:
        """Return what a drawing of the cylinder on a page needs, SI units."""
        model = self.model
        return {
            'stroke': model.cylinder.stroke,
            'bore': model.cylinder.bore,
            'rod_diameter': model.cylinder.rod_diameter,
            'atmospheric_pressure': model.gas.atmospheric_pressure,
            'supply_pressure': model.operation.supply_pressure,
            'intake_voltage': model.valve.intake_voltage,
            'exhaust_voltage': model.valve.exhaust_voltage,
        }


def load_configuration(source: str | Path, **overrides: object) -> RigConfiguration:
    """
    Read a configuration and apply overrides; sections it lacks come from ``config/rig.yaml``.

    :param source: name of a shipped cylinder, or path of a YAML file
    :param overrides: fields of :data:`OVERRIDES` in SI units; ``seed``; ``sensors`` ('rig',
        'ideal'); ``friction`` (name of a friction law). None leaves a value as it is
    :raises RigError: for anything missing, unknown, of a wrong unit or out of range
    """
    path = locate(source, 'cylinder', 'cylinder_*.yaml')
    configuration = configuration_from_yaml(read_text(path), str(path))
    return override(configuration, {key: x for key, x in overrides.items() if x is not None})


def configuration_from_yaml(text: str, origin: str) -> RigConfiguration:
    """
    Read a configuration from text.

    :param origin: what to call the text in an error
    :raises RigError: as :func:`load_configuration`
    """
    merged = {**_shared(), **_mapping(text, origin)}
    sections = {
        key: read_section(section, merged.get(key), f'{origin}: {key}')
        for key, section in _ALL_SECTIONS.items()
    }
    sensors, sampling = sections.pop('sensors'), sections.pop('sampling')
    configuration = RigConfiguration(
        name=_name(merged.get('name', Path(origin).stem), origin),
        model=Model(**sections),
        effects=read_effects(merged.get('effects'), origin),
        sensors=sensors,
        interval_ns=int(sampling.interval),
        seed=int(sampling.seed),
        repeatability=read_values(
            merged.get('repeatability'), REPEATABILITY, f'{origin}: repeatability'
        ),
    )
    return _consistent(configuration, origin)


def _mapping(text: str, origin: str) -> dict[str, Any]:
    keys = 'name', *_ALL_SECTIONS, 'effects', 'repeatability'
    return mapping_of(parse_yaml(text, origin), keys, origin)


def override(configuration: RigConfiguration, changes: Mapping[str, object]) -> RigConfiguration:
    """Return the configuration with the changes of :func:`load_configuration` applied."""
    for key, value in changes.items():
        if key in OVERRIDES:
            quantity = OVERRIDES[key]
            if key == 'initial_position':
                quantity = replace(quantity, high=configuration.model.cylinder.stroke)
            number = quantity.check(_real(value, key), key)
            configuration = configuration.with_parameter('operation', key, number)
        elif key == 'seed':
            seed = cast(Quantity, specifications(Sampling)['seed']).check(_real(value, key), key)
            configuration = replace(configuration, seed=int(seed))
        elif key == 'sensors':
            kind = cast(Choice, specifications(Sensors)['kind']).parse(value, key)
            sensors = configuration.sensors._replace(kind=kind)
            configuration = replace(configuration, sensors=sensors)
        elif key == 'friction':
            law = cast(Choice, specifications(Friction)['model']).parse(value, key)
            _check_friction_law(configuration.effects, law, key)
            configuration = configuration.with_parameter('friction', 'model', law)
        else:
            allowed = [*OVERRIDES, 'seed', 'sensors', 'friction']
            raise RigError(f'override: {unknown(key, allowed)}')
    return _consistent(configuration, configuration.name)


@functools.cache
def _shared() -> dict[str, Any]:
    path = configuration_folder() / 'rig.yaml'
    return _mapping(read_text(path), str(path))


def _name(name: object, origin: str) -> str:
    text = str(name)
    if not (text.isprintable() and len(text) <= LONGEST_NAME):
        raise RigError(
            f'{origin}: name: {text!r} is not a line of up to {LONGEST_NAME} characters'
        )
    return text


def read_effects(data: object, origin: str) -> dict[str, Any]:
    """Return name -> parameters of the effects of a file; RigError for what is none."""
    if not isinstance(data, dict | None):
        raise RigError(f'{origin}: effects: expected a mapping of name: {{parameter: value}}')
    chosen = {}
    for name, values in (data or {}).items():
        effect = library.load(str(name), f'{origin}: effects')
        chosen[str(name)] = read_effect(effect, values, f'{origin}: effects.{name}')
    return chosen


def between_recordings(values: Mapping[str, float]) -> dict[str, float]:
    """Return those of some standard deviations that are of quantities, and not of balances."""
    return {name: value for name, value in values.items() if name not in _BALANCES}


def _check_friction_law(effects: Mapping[str, Any], law: int, origin: str) -> None:
    """Refuse an effect that completes another friction law than the one chosen."""
    for name, own in effects.items():
        effect = library.load(name)
        acts = without_shape(own) != effect.null
        if effect.laws and acts and FRICTION_MODELS[law] not in effect.laws:
            raise RigError(
                f'{origin}: effects.{name} is for friction.model {" or ".join(effect.laws)}, '
                f'not for {FRICTION_MODELS[law]}'
            )


def _consistent(configuration: RigConfiguration, origin: str) -> RigConfiguration:
    """Check what no single value shows; return the configuration."""
    cylinder, law = configuration.model.cylinder, configuration.model.friction
    valve, operation = configuration.model.valve, configuration.model.operation
    full, rod = (math.pi / 4.0 * d**2 for d in (cylinder.bore, cylinder.rod_diameter))
    cap_error = abs(cylinder.cap_area / full - 1.0)
    rod_error = abs(cylinder.rod_area / (full - rod) - 1.0)
    share, start, stroke = f'{AREA_AGREEMENT:.0%}', operation.initial_position, cylinder.stroke
    stiffnesses, limits = len(law.element_stiffness), len(law.element_limit)
    checks = {
        'cylinder.rod_area must be below cap_area': cylinder.rod_area < cylinder.cap_area,
        f'cylinder.cap_area must agree with the bore to {share}': cap_error <= AREA_AGREEMENT,
        f'cylinder.rod_area must agree with the diameters to {share}': rod_error <= AREA_AGREEMENT,
        'friction.breakaway_force must be at least coulomb_force': (
            law.breakaway_force >= law.coulomb_force
        ),
        'friction.stop_velocity must not be above start_velocity': (
            law.stop_velocity <= law.start_velocity
        ),
        'friction.element_stiffness needs at least one entry': stiffnesses >= 1,
        'friction.element_limit must have one entry fewer than element_stiffness': (
            limits == stiffnesses - 1
        ),
        'valve.exhaust_voltage must be below intake_voltage': (
            valve.exhaust_voltage < valve.intake_voltage
        ),
        'valve.exhaust_zero_voltage must be at least exhaust_voltage': (
            valve.exhaust_zero_voltage >= valve.exhaust_voltage
        ),
        f'operation.initial_position {start:g} m must be within the stroke, 0 to {stroke:g} m': (
            start <= stroke
        ),
    }
    for message, holds in checks.items():
        if not holds:
            raise RigError(f'{origin}: {message}')
    _check_friction_law(configuration.effects, law.model, origin)
    return configuration


def _real(value: object, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise RigError(f'{where}: {value!r} is not a number')
    return float(value)
