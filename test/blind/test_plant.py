"""The second plant against the package's: written twice, solved by two methods, one motion."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.plant import Plant as PackagePlant
from pneu_rig_ros.rig import configuration_from_yaml
from pneu_rig_ros.scenarios.experiments import FIT, Experiment, set_up
from pneu_rig_ros.scenarios.hidden import (
    CYLINDERS,
    EFFECTS,
    Changes,
    Secret,
    hide,
    true_parameters,
)

from .bags import valve_voltages
from .constants import HIDDEN
from .plant import Plant, flatten
from .rig import INTERVAL, command, set_up_for, truth_of
from .sensors import distorted
from .settings import changed, model_file, operation, settings

EQUATIONS: dict[str, Changes] = {
    'as shipped': {},
    'F_s fades while sliding': {
        'friction.static_friction_reading': 'fades_while_sliding',
        'friction.memory_time': 0.5,
    },
    'exhaust without a jump': {'valve.exhaust_zero_voltage': 2.35},
    'exhaust as printed': {'valve.exhaust_zero_voltage': 2.65},
}
"""What both plants may have in place of the shipped equations."""
HIDDEN_IN = [(effect, 'as shipped') for effect in EFFECTS] + [
    ('dwell_static_friction', 'F_s fades while sliding'),
    *(
        pytest.param(effect, f'exhaust {how}', marks=pytest.mark.long)
        for how in ('without a jump', 'as printed')
        for effect in ('nonlinear_opening', 'valve_lag', 'valve_null_leak', 'spool_hysteresis')
    ),
]
AGREEMENT = 1e-4
"""Share of full scale."""
SETTLED = 1e-6
"""Two tolerances of one method agree so well where the motion is not yet sensitive to them."""


@pytest.mark.parametrize(
    'room',
    [
        'plant',
        'gas',
        'motion',
        'constants',
        'sensors',
        'settings',
        'imposed',
        'along',
        'contributions',
        'windows',
        'runs',
    ],
)
def test_second_plant_has_nothing_of_the_package(room: str) -> None:
    assert 'pneu_rig_ros' not in Path(__file__).with_name(f'{room}.py').read_text()


def signals(
    cylinder: str, secret: Secret, experiment: Experiment, samples: int, tolerance: float
) -> np.ndarray:
    """Return x [m], p1, p2 [Pa] of the second plant, and whether it rests, shape (4, n)."""
    true = truth_of(cylinder, secret)
    prepared = set_up_for(true, cylinder, experiment)
    hidden = flatten(secret.effects)
    inside = {name: value for name, value in hidden.items() if name in HIDDEN}
    voltages = valve_voltages(command(experiment, cylinder))[:samples]
    motion = Plant(prepared, inside, tolerance).run(voltages, INTERVAL)
    return np.vstack([distorted(motion, hidden), motion.sticking])[:, 1:]


def expected(
    cylinder: str, secret: Secret, effect: str, experiment: Experiment, samples: int
) -> np.ndarray:
    """Return x, p1, p2 of the package's plant with the library's effect, shape (3, n)."""
    friction, stroke = settings(cylinder)['friction'], settings(cylinder)['cylinder']['stroke']
    changes = operation(set_up(experiment, cylinder, stroke))
    text = model_file(cylinder, {**secret.model, **changes})
    effects = library.nulls()
    if effect:
        values = true_parameters(effect, secret, friction)
        effects[effect] = library.load(effect).parameters(**values)
    model = configuration_from_yaml(text, 'test').model
    plant = PackagePlant(model, effects, tolerance=1e-7)
    voltages = valve_voltages(command(experiment, cylinder))[:samples]
    run = plant.run(voltages, INTERVAL)
    return np.stack([run.position_reading, run.pressure_1_reading, run.pressure_2_reading])


def scales(cylinder: str) -> np.ndarray:
    return np.array([[settings(cylinder)['cylinder']['stroke']], [5e5], [5e5]])


def determined(cylinder: str, first: np.ndarray, second: np.ndarray) -> int:
    """Return how many samples go by before two solutions of the same equations part."""
    apart = np.max(np.abs(first[:3] - second[:3]) / scales(cylinder), axis=0) > SETTLED
    return int(np.argmax(apart)) if apart.any() else len(apart)


def each_in_short(usual: str) -> list[Any]:
    """Return cylinders and equations: in short as shipped, and the others of one cylinder."""
    return [
        pytest.param(cylinder, equations, marks=[] if short else [pytest.mark.long])
        for cylinder in CYLINDERS
        for equations in EQUATIONS
        for short in [cylinder == usual or equations == 'as shipped']
    ]


@pytest.mark.usefixtures('plants')
@pytest.mark.parametrize('experiment', [FIT[0], FIT[2]], ids=['stick-slip', 'onto the stop'])
@pytest.mark.parametrize(('cylinder', 'equations'), each_in_short('cylinder_2'))
def test_moves_as_the_package_plant_does(
    cylinder: str, equations: str, experiment: Experiment
) -> None:
    samples = round(14.0 / INTERVAL)
    both = Secret({}, EQUATIONS[equations], EQUATIONS[equations])
    coarse, fine = (
        signals(cylinder, both, experiment, samples, tolerance) for tolerance in (1e-8, 1e-9)
    )
    model = expected(cylinder, both, '', experiment, samples)
    until = determined(cylinder, coarse, fine)
    breakaways = np.sum(np.diff(fine[3, :until]) < 0.0)
    assert until * INTERVAL > 2.0
    assert breakaways >= 1
    gap = np.max(np.abs(fine[:3] - model) / scales(cylinder), axis=0)
    assert gap[:until].max() < AGREEMENT


@pytest.mark.usefixtures('plants')
@pytest.mark.parametrize(('effect', 'equations'), HIDDEN_IN)
def test_hides_what_the_library_describes(effect: str, equations: str) -> None:
    cylinder, samples = 'cylinder_2', round(8.5 / INTERVAL)
    # a medium dwell has the gamma of the law
    strength = 'medium' if equations == 'as shipped' else 'weak'
    secret = hide(effect, cylinder, strength, settings(cylinder)['friction'])
    for changes in secret[1:]:
        changes.update(EQUATIONS[equations])
    for experiment in (FIT[0], FIT[2]):
        truth = signals(cylinder, secret, experiment, samples, 1e-8)
        model = expected(cylinder, secret, effect, experiment, samples)
        until = determined(cylinder, truth, signals(cylinder, secret, experiment, samples, 1e-9))
        gap = np.max(np.abs(truth[:3] - model) / scales(cylinder), axis=0)
        assert until * INTERVAL > 2.0
        assert gap[:until].max() < AGREEMENT


def test_gas_stays_in_shut_chambers() -> None:
    plant = Plant(changed(settings('cylinder_2'), {'operation.initial_pressure_1': 1.3e5}))
    plant.run(np.full((2000, 2), 2.5), INTERVAL)
    masses = plant.states[:, 6:8]
    assert np.ptp(plant.states[:, 0]) > 1e-6  # it has moved
    assert masses == pytest.approx(np.tile(masses[0], (len(masses), 1)), rel=1e-12)


def test_model_file_takes_lists_in_their_units() -> None:
    changes = {'friction.element_stiffness': [2e4, 1e4], 'friction.element_limit': [2.0]}
    law = configuration_from_yaml(model_file('cylinder_1', changes), 'model').model.friction
    assert (law.element_stiffness, law.element_limit) == ((2e4, 1e4), (2.0,))
