"""Random rigs: any values that the configuration takes, any friction law, some effects."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.effect import Balance
from pneu_rig_ros.model.parameters import FRICTION_MODELS, SECTIONS
from pneu_rig_ros.model.quantity import Choice, Quantity, QuantityList, specifications
from pneu_rig_ros.rig import RigConfiguration, configuration_from_yaml, load_configuration

DURATION = 1.0
"""Of a run [s]."""
FULL_VOLTAGE = 5.0
SPREAD = 1.0
"""Half the rigs are like the shipped ones but for factors up to ten to this power."""
DECADES = 6.0
"""The others have values from anywhere in their ranges, by order of magnitude; of a range from
zero, the uppermost decades."""
LATER = ('memory_time', 'exhaust_zero_voltage')
"""Parameters that came later: drawn apart, so that the numbers of known cases stay theirs."""


class Case(NamedTuple):
    """
    One rig and what it is driven by.

    :param voltages: u1, u2 [V] one after the other, shape (n, 2), each for DURATION / n
    """

    configuration: RigConfiguration
    voltages: NDArray[np.float64]


def case(seed: int) -> Case:
    """Return the case of a number; the same one always."""
    random, later = (np.random.default_rng([seed, stream]) for stream in (6, 7))
    while True:
        try:
            configuration = _rig(random, later)
            configuration_from_yaml(configuration.to_yaml(), f'rig {seed}')
        except RigError:
            continue  # such as a friction law that an effect is not for
        return Case(configuration, _voltages(random))


def _voltages(random: np.random.Generator) -> NDArray[np.float64]:
    """Return steps anywhere, small ones about the middle, or both valves as by Eq. 1."""
    count = int(random.choice([1, 2, 5, 20]))
    kind = random.integers(3)
    if kind == 0:
        return random.uniform(0.0, FULL_VOLTAGE, (count, 2))
    width = 0.6 if kind == 1 else 2.5
    u = random.uniform(-width, width, count)
    return np.column_stack([2.5 + u, 2.5 - u])


def _rig(random: np.random.Generator, later: np.random.Generator) -> RigConfiguration:
    configuration = load_configuration(f'cylinder_{random.integers(1, 4)}')
    wide = bool(random.random() < 0.5)
    model = configuration.model
    for name, kind in SECTIONS.items():
        shipped = getattr(model, name)
        values = {
            key: _value(spec, getattr(shipped, key), wide, later if key in LATER else random)
            for key, spec in specifications(kind).items()
        }
        model = model._replace(**{name: kind(**values)})
    agreeing = _agreeing(model, random, later)
    return replace(configuration, model=agreeing, effects=_effects(model, wide, random))


def _value(spec: Any, shipped: Any, wide: bool, random: np.random.Generator) -> Any:
    """Return a value in the range of a specification."""
    if isinstance(spec, Choice):
        return int(random.integers(len(spec.names)))
    if isinstance(spec, QuantityList):
        return tuple(_value(spec.item, value, wide, random) for value in shipped)
    return _number(spec, shipped, wide, random)


def _number(spec: Quantity, shipped: float, wide: bool, random: np.random.Generator) -> float:
    if not wide and shipped:
        return spec.within(shipped * 10.0 ** random.uniform(-SPREAD, SPREAD))
    if spec.low <= 0.0 and random.random() < 0.2:
        return max(spec.low, 0.0)
    if spec.low < 0.0:
        return float(random.uniform(spec.low, spec.high))
    low = math.log10(max(spec.low, spec.high * 10.0**-DECADES))
    return spec.within(10.0 ** random.uniform(low, math.log10(spec.high)))


def _agreeing(model: Any, random: np.random.Generator, later: np.random.Generator) -> Any:
    """Return a model whose values do not contradict each other."""
    cylinder, law = model.cylinder, model.friction
    bore = min(max(cylinder.bore, 2e-3), 0.35)
    rod = bore * random.uniform(0.1, 0.9)
    full = math.pi / 4.0 * bore**2
    cylinder = cylinder._replace(
        bore=bore,
        rod_diameter=max(rod, 1e-3),
        cap_area=full,
        rod_area=full - math.pi / 4.0 * max(rod, 1e-3) ** 2,
    )
    law = law._replace(
        breakaway_force=max(law.breakaway_force, law.coulomb_force),
        start_velocity=max(law.start_velocity, law.stop_velocity),
        element_limit=law.element_limit[: len(law.element_stiffness) - 1],
    )
    exhaust, intake = sorted(random.uniform(0.0, FULL_VOLTAGE, 2))
    if random.random() < 0.7:
        exhaust, intake = model.valve.exhaust_voltage, model.valve.intake_voltage
    zero = later.choice([exhaust, intake, later.uniform(exhaust, FULL_VOLTAGE)])
    valve = model.valve._replace(
        exhaust_voltage=float(exhaust),
        intake_voltage=float(intake),
        exhaust_zero_voltage=float(zero),
    )
    start = cylinder.stroke * random.choice([0.0, random.random(), 1.0])
    return model._replace(
        cylinder=cylinder,
        friction=law,
        valve=valve,
        operation=model.operation._replace(initial_position=float(start)),
    )


@cache
def _physical() -> tuple[str, ...]:
    """
    Return the effects that stand for physics, without heat by states: no trajectory has these.

    The others describe what has no name.
    """
    loaded = {name: library.load(name) for name in library.causes()}
    return tuple(n for n, e in loaded.items() if not (e.balance is Balance.HEAT and e.states))


def _effects(model: Any, wide: bool, random: np.random.Generator) -> dict[str, Any]:
    """Return none to four effects that go with the friction law."""
    law = FRICTION_MODELS[model.friction.model]
    fitting = [n for n in _physical() if law in (library.load(n).laws or FRICTION_MODELS)]
    names = random.choice(fitting, random.integers(0, 5), replace=False)
    chosen = {}
    for name in sorted(map(str, names)):
        effect = library.load(name)
        probe = effect.probes[random.integers(len(effect.probes))]
        values = {
            key: _value(spec, getattr(probe, key), wide, random)
            for key, spec in specifications(effect.parameters).items()
        }
        chosen[name] = effect.parameters(**values)
    return chosen
