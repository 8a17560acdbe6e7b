"""What is hidden: an effect of the library, drawn from a seed, of medium strength."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pneu_rig_ros.hiding.experiments import CYLINDER
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.quantity import write_section
from pneu_rig_ros.rig import RigConfiguration, load_configuration
from pneu_rig_ros.rig.configuration import configuration_from_yaml

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
"""Effects that show well above the noise in runs as short as these."""


@dataclass(frozen=True)
class Secret:
    """
    An effect that the rig has and the model lacks.

    :param effect: its name
    :param model: the rig without it
    :param truth: the rig with it
    """

    effect: str
    model: RigConfiguration
    truth: RigConfiguration

    @property
    def text(self) -> str:
        """The effect's parameters for a person, with their units."""
        values = write_section(self.truth.effects[self.effect])
        return ', '.join(f'{name} {value}' for name, value in values.items())


def hide(seed: int, name: str | None = None) -> Secret:
    """
    Hide an effect in the rig of the demonstration.

    :param seed: of the draw among :data:`DRAWN`
    :param name: of the effect; drawn when not given
    :raises RigError: when there is no such effect, or the rig's friction law has it already
    """
    drawn = str(np.random.default_rng(seed).choice(DRAWN))
    chosen = drawn if name is None else library.cause(name, '--effect')
    model = plain_model()
    truth = replace(model, effects={chosen: medium(chosen)})
    configuration_from_yaml(truth.to_yaml(), CYLINDER)
    return Secret(chosen, model, truth)


def plain_model() -> RigConfiguration:
    """
    Return the shipped cylinder with sensors that have noise but no error of gain.

    Errors of gain would be fitted along with what is missing, and hide the weaker effects.
    """
    shipped = load_configuration(CYLINDER)
    sensors = shipped.sensors._replace(position_class=0.0, pressure_class=0.0)
    return replace(shipped, sensors=sensors)


def medium(name: str) -> Any:
    """Return an effect's parameters of medium strength: the middle one of its probes."""
    probes = library.load(name).probes
    return probes[(len(probes) - 1) // 2]
