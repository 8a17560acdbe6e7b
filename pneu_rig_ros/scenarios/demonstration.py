"""The rig of `pneu-rig gap`: an effect drawn from a seed, in the plant and not in its model."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.parameters import FRICTION_MODELS
from pneu_rig_ros.model.quantity import write_section
from pneu_rig_ros.rig import RigConfiguration, load_configuration
from pneu_rig_ros.scenarios.hidden import LAWS, Changes, hide, true_parameters

CYLINDER, STRENGTH = 'cylinder_1', 'medium'
DRAWN = (
    'supply_droop',
    'cross_piston_leak',
    'chamber_leak',
    'wall_heat_transfer',
    'valve_lag',
    'line_lag',
    'spool_hysteresis',
    'nonlinear_opening',
    'valve_null_leak',
    'pressure_dependent_friction',
    'direction_dependent_friction',
    'position_dependent_friction',
    'inclination',
    'load_spring',
)
"""Effects that show well above the noise, each apart from the others."""


@dataclass(frozen=True)
class HiddenEffect:
    """
    An effect that the rig has and the model lacks.

    :param effect: its name
    :param parameters: its true parameters, as the library names them [SI]
    :param model: the rig without it
    :param truth: the rig with it
    """

    effect: str
    parameters: dict[str, float]
    model: RigConfiguration
    truth: RigConfiguration

    @property
    def text(self) -> str:
        """The effect's parameters as text, with their units."""
        values = write_section(library.load(self.effect).parameters(**self.parameters))
        return ', '.join(f'{name} {value}' for name, value in values.items())


def draw(seed: int, name: str | None = None) -> HiddenEffect:
    """
    Hide an effect of medium strength in the rig of the demonstration.

    :param seed: of the draw among :data:`DRAWN`
    :param name: of the effect; drawn when not given
    :raises RigError: when there is no such effect
    """
    drawn = str(np.random.default_rng(seed).choice(DRAWN))
    chosen = drawn if name is None else library.cause(name, '--effect')
    plain = plain_rig()
    friction = plain.model.friction._asdict()
    secret = hide(chosen, CYLINDER, STRENGTH, friction)
    values = true_parameters(chosen, secret, friction)
    truth = changed(plain, secret.truth)
    if chosen not in LAWS:
        truth = replace(truth, effects={chosen: library.load(chosen).parameters(**values)})
    return HiddenEffect(chosen, values, changed(plain, secret.model), truth)


def plain_rig() -> RigConfiguration:
    """
    Return the shipped cylinder with sensors that have noise but no error of gain.

    Errors of gain would be fitted along with what is missing, and hide the weaker effects.
    """
    shipped = load_configuration(CYLINDER)
    sensors = shipped.sensors._replace(position_class=0.0, pressure_class=0.0)
    return replace(shipped, sensors=sensors)


def changed(rig: RigConfiguration, changes: Changes) -> RigConfiguration:
    """Return a rig with section.key replaced."""
    model = rig.model
    for name, value in changes.items():
        section, key = name.split('.')
        values = getattr(model, section)._replace(**{key: _as_stored(key, value)})
        model = model._replace(**{section: values})
    return replace(rig, model=model)


def _as_stored(key: str, value: Any) -> Any:
    """Return a value as a section of the model holds it: choices by number, lists as tuples."""
    if key == 'model':
        return FRICTION_MODELS.index(value)
    return tuple(value) if isinstance(value, list) else value
