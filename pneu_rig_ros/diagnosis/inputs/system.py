"""
The system under test: a rig, or the part of one that a file describes and a recording shows.

Sections and keys are those of a rig's configuration, as far as they are known::

    name: sealed_chambers
    cylinder: {cap_area: 0.0127 m^2, cap_dead_volume: 0.025 m^3, ...}
    gas: {gas_constant: 296.8 J/(kg*K), ...}
    valve: shut                           # or the section of a configuration
    fixed: {position: 0 m}                # constant, and not recorded
    each_recording: [force_offset]        # differs between recordings, see ``nuisances``
    refit:                                # may be wrong, within a range
      cylinder.cap_dead_volume: [0.02 m^3, 0.03 m^3]
    repeatability: {force: 0.6 N}         # what the model left of earlier recordings, of a rig too

A balance is open when its signals are recorded and the file has the sections it needs.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.nuisances import (
    INITIAL_TEMPERATURE,
    NUISANCES,
    USUAL,
    read_nuisances,
)
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.parameters import SECTIONS, Model
from pneu_rig_ros.model.quantity import (
    Quantity,
    mapping_of,
    read_section,
    read_values,
    specifications,
    write_section,
    write_values,
)
from pneu_rig_ros.model.shape import write_effect
from pneu_rig_ros.rig import RigConfiguration, load_configuration
from pneu_rig_ros.rig.configuration import REPEATABILITY, between_recordings, read_effects
from pneu_rig_ros.rig.sensors import Sensors
from pneu_rig_ros.rig.yaml_file import read_yaml, to_yaml

SHUT = 'shut'
"""In place of the valve section: nothing flows."""
OWN_KEYS = ('fixed', 'each_recording', 'refit')
"""Keys that a rig's configuration does not have."""
FIXED = {
    'position': Quantity('m', 0.0, 10.0, 'of a piston that does not move'),
    'pressure_1': Quantity('Pa', 5e4, 1.1e6, 'of a chamber at constant pressure'),
    'pressure_2': Quantity('Pa', 5e4, 1.1e6, 'of a chamber at constant pressure'),
}
"""Signals that may be constant and not recorded."""
QUANTITIES = {
    f'{name}.{key}': quantity
    for name, section in SECTIONS.items()
    for key, specification in specifications(section).items()
    if isinstance(quantity := getattr(specification, 'item', specification), Quantity)
}
"""Parameter 'section.name' -> its unit and range, of an element where it is a list."""
PLACEHOLDERS: dict[str, dict[str, Any]] = {
    'cylinder': {
        'cap_area': 1e-3,
        'rod_area': 1e-3,
        'cap_dead_volume': 0.1,
        'rod_dead_volume': 0.1,
        'stroke': 10.0,
        'moving_mass': 1e-3,
    },
    'friction': {
        'model': 0,
        'breakaway_force': 1e5,
        'coulomb_force': 1e5,
        'viscous_coefficient': 0.0,
        'micro_viscous_coefficient': 0.0,
        'element_stiffness': (1e6,),
        'element_limit': (),
        'stop_velocity': 5e-4,
        'start_velocity': 1e-3,
        'fluid_time_constant': 0.0,
    },
    'operation': {'supply_pressure': 1.1e6, 'load_mass': 0.0, 'rest_time': 0.0},
}
"""
Section -> values of keys that a file does not give [SI]. No open balance uses any, as without its
own keys a balance is closed, but for the mass: that of a bench need not be given, and its
acceleration then makes no force. 1 g is the least a mass can be.
"""


@dataclass(frozen=True)
class System:
    """
    A model of the system with what a file says about it.

    :param hypothesis: its parameters and effects
    :param given: section -> keys that its file gives
    :param sensors: data sheet, None where it is unknown
    :param shut: whether no valve is connected
    :param fixed: signal -> constant value [SI]
    :param each_recording: nuisance parameter -> its standard deviation [SI]
    :param refit: parameter -> range within which it may be wrong [SI]
    :param repeatability: balance -> standard deviation of what the model left of recordings to
        which it was fitted or on which it was validated [unit of the balance], and quantity ->
        that between recordings [its unit]
    :param rig: the configuration of a complete rig, else None
    """

    name: str
    hypothesis: Hypothesis
    given: Mapping[str, tuple[str, ...]]
    sensors: Sensors | None = None
    shut: bool = False
    fixed: Mapping[str, float] = field(default_factory=dict)
    each_recording: Mapping[str, float] = field(default_factory=dict)
    refit: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    repeatability: Mapping[str, float] = field(default_factory=dict)
    rig: RigConfiguration | None = None

    @property
    def uncalibrated(self) -> bool:
        """Whether the sensors are known to their accuracy class only."""
        sensors = self.sensors
        return sensors is not None and max(sensors.position_class, sensors.pressure_class) > 0.0

    @property
    def spreads(self) -> dict[str, float]:
        """Quantity -> its standard deviation between recordings, of those that are known."""
        return between_recordings(self.repeatability)

    @property
    def constant_volume(self) -> bool:
        """Whether gas is sealed in chambers of constant volume."""
        return self.shut and 'position' in self.fixed

    def to_yaml(self) -> str:
        """Return the text of a file that loads back as this system."""
        hypothesis = self.hypothesis
        if self.rig is not None:
            effects = dict(hypothesis.effects)
            rig = replace(self.rig, model=hypothesis.model, effects=effects)
            return replace(rig, repeatability=self.repeatability).to_yaml()
        data: dict[str, Any] = {'name': self.name}
        for section in SECTIONS:
            written = write_section(getattr(hypothesis.model, section))
            changed = [full.split('.')[1] for full in self.refit if full.startswith(section)]
            keys = dict.fromkeys([*self.given.get(section, ()), *changed])
            if keys:
                data[section] = {key: written[key] for key in keys}
        if self.shut:
            data['valve'] = SHUT
        if self.sensors is not None:
            data['sensors'] = write_section(self.sensors)
        data['effects'] = {name: write_effect(own) for name, own in hypothesis.effects.items()}
        data['fixed'] = write_values(self.fixed, FIXED)
        data['each_recording'] = write_values(self.each_recording, NUISANCES)
        data['refit'] = {
            full: [QUANTITIES[full].format(limit) for limit in limits]
            for full, limits in self.refit.items()
        }
        data['repeatability'] = write_values(self.repeatability, REPEATABILITY)
        return to_yaml(data)


def load_system(source: Path | str) -> System:
    """
    Read the file of a system, or take the name of a shipped cylinder.

    :raises RigError: for a key that is missing or unknown, a wrong unit or a value out of range
    """
    data = read_yaml(source) if Path(source).is_file() else None
    if data is not None and not _is_rig(data):
        return _read(data, str(source))
    rig = load_configuration(source)
    given = {name: tuple(specifications(section)) for name, section in SECTIONS.items()}
    hypothesis = Hypothesis(rig.model, dict(rig.effects))
    kept = rig.repeatability
    return System(rig.name, hypothesis, given, rig.sensors, repeatability=kept, rig=rig)


def _is_rig(data: dict[str, Any]) -> bool:
    """Return whether a file describes a whole rig: cylinder and friction, and no key of a part."""
    if any(key in data for key in OWN_KEYS) or data.get('valve') == SHUT:
        return False
    return all(
        isinstance(data.get(name), dict) and set(specifications(SECTIONS[name])) <= set(data[name])
        for name in ('cylinder', 'friction')
    )


def _read(data: dict[str, Any], origin: str) -> System:
    mapping_of(data, ('name', *SECTIONS, 'effects', 'sensors', 'repeatability', *OWN_KEYS), origin)
    shut = data.get('valve') == SHUT
    model, given = load_configuration('cylinder_1').model, {}
    for name, section in SECTIONS.items():
        content = {} if name == 'valve' and shut else data.get(name) or {}
        values = read_values(content, specifications(section), f'{origin}: {name}')
        given[name] = tuple(values)
        defaults = dict(PLACEHOLDERS.get(name, {}))
        if 'exhaust_voltage' in values:  # a port that opens from there, without a jump
            defaults['exhaust_zero_voltage'] = values['exhaust_voltage']
        changed = getattr(model, name)._replace(**{**defaults, **values})
        model = model._replace(**{name: changed})
    if (sensors := data.get('sensors')) is not None:
        sensors = read_section(Sensors, sensors, f'{origin}: sensors')
    fixed = read_values(data.get('fixed'), FIXED, f'{origin}: fixed')
    vessel = shut and 'position' in fixed
    refit = _refit(data.get('refit'), model, origin)
    volume = next((name for name in refit if name.endswith('dead_volume')), '')
    if vessel and volume:
        raise RigError(
            f'{origin}: refit.{volume}: cannot be found where position is fixed and the valves '
            'are shut; state any volume, to which leak and heat transfer are in proportion'
        )
    hypothesis = Hypothesis(model, read_effects(data.get('effects'), origin))
    each_recording = read_nuisances(data.get('each_recording'), f'{origin}: each_recording')
    if vessel:  # which has just been filled, and its gas warmed by an unmeasured amount
        each_recording = {INITIAL_TEMPERATURE: USUAL[INITIAL_TEMPERATURE], **each_recording}
    return System(
        str(data.get('name', Path(origin).stem)),
        hypothesis,
        given,
        sensors,
        shut,
        fixed,
        each_recording,
        refit,
        read_values(data.get('repeatability'), REPEATABILITY, f'{origin}: repeatability'),
    )


def _refit(data: object, model: Model, origin: str) -> dict[str, tuple[float, float]]:
    """Return parameter -> range; RigError for an unknown one or a range without the value."""
    if not isinstance(data, dict | None):
        raise RigError(f'{origin}: refit: expected a mapping of section.name: [low, high]')
    ranges = {}
    for full, limits in mapping_of(data or {}, QUANTITIES, f'{origin}: refit').items():
        where = f'{origin}: refit.{full}'
        if not isinstance(limits, list) or len(limits) != 2:
            raise RigError(f'{where}: expected [low, high]')
        low, high = (QUANTITIES[full].parse(limit, where) for limit in limits)
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
