"""
The effects that can be hidden in a rig, and their strengths.

Each row: effect, why it is visible in the experiments, and its true parameters, weak, medium and
strong, for each cylinder. The friction laws themselves are hidden by giving a lower level of the
friction law as the model.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

STRENGTHS = ('weak', 'medium', 'strong')
CYLINDERS = ('cylinder_1', 'cylinder_2', 'cylinder_3')
Changes = dict[str, Any]


class Secret(NamedTuple):
    """What makes the truth differ from the model."""

    effects: dict[str, dict[str, float]]
    """Effect -> parameter -> value, in the second plant's equations or its sensors."""
    truth: Changes
    """section.key -> value, in the true rig only."""
    model: Changes
    """section.key -> value, in the model that is given."""


def _by_size(*values: float) -> tuple[tuple[float, ...], ...]:
    """Return rows weak, medium, strong of one value for each cylinder."""
    return tuple((value, value, value) for value in values)


def _about(*medium: float) -> tuple[tuple[float, ...], ...]:
    """Return rows weak, medium, strong of 0.3, 1 and 3 times a value for each cylinder."""
    return tuple(tuple(factor * value for value in medium) for factor in (0.3, 1.0, 3.0))


# effect -> parameter -> (weak, medium, strong), each for cylinder 1, 2, 3
CONTRIBUTIONS: dict[str, dict[str, tuple[tuple[float, ...], ...]]] = {
    # flows of 2e-5 (slow) to 1.4e-4 kg/s (fast): 10 to 70 kPa of some 5e5 Pa
    'supply_droop': {'resistance': _by_size(2e8, 5e8, 1.5e9)},
    # the intake opens 7e-9 m^2 in a slow stroke; the pressures differ most at the stops
    'cross_piston_leak': {'area': _about(1e-9, 1.5e-9, 3e-9)},
    # seen in each pause after filling; more at the rod end, where the rod's seal is
    'chamber_leak': {'area_1': _about(5e-10, 7e-10, 1.5e-9), 'area_2': _about(1e-9, 1.5e-9, 3e-9)},
    # fills or empties a shut chamber, and robs the slow strokes
    'valve_null_leak': {
        'intake_area': _about(4e-10, 4e-10, 4e-10),
        'exhaust_area': _about(1e-9, 1e-9, 1e-9),
    },
    # 10 to 20 W/(m^2 K) on the walls; seen as the pressure settles after filling
    'wall_heat_transfer': {
        'conductance_1': _about(0.3, 0.4, 0.8),
        'conductance_2': _about(0.4, 0.5, 0.8),
    },
    # metres of line; seen after each change of the command
    'line_lag': {'time_constant': _by_size(0.01, 0.03, 0.08)},
    'valve_lag': {'time_constant': _by_size(0.01, 0.03, 0.1)},
    # the ports open 0.15 V from the centre; a slow stroke leaves 0.14 V of opening
    'spool_hysteresis': {'width': _by_size(0.01, 0.03, 0.08)},
    'nonlinear_opening': {
        'intake_exponent': _by_size(1.03, 1.1, 1.4),
        'exhaust_exponent': _by_size(1.03, 1.1, 1.4),
    },
    # wider seals, steeper growth; 0.1 to 2 bar in the chambers
    'pressure_dependent_friction': {'slope': _about(2e-5, 4e-5, 8e-5)},
    'direction_dependent_friction': {'asymmetry': _by_size(0.04, 0.12, 0.35)},
    # on the outstroke alone, at up to 0.1 m/s
    'direction_dependent_viscous_friction': {
        'asymmetry': _about(4.0, 15.0, 15.0),
        'one_sidedness': _by_size(1.0, 1.0, 1.0),
    },
    'position_dependent_friction': {'gradient': _by_size(0.1, 0.3, 0.8)},
    # the work of friction in one bag is some 2, 3 and 0.5 J
    'friction_warm_up': {'drop': _by_size(0.1, 0.25, 0.5), 'work': ((1.5, 1.5, 0.2),) * 3},
    # 0.45 to 6 kg move: 0.3 to 3.5 N at 0.06 rad
    'inclination': {'angle': _by_size(0.02, 0.06, 0.2)},
    'load_spring': {
        'stiffness': _about(20.0, 60.0, 120.0),
        'compression': _by_size(0.02, 0.02, 0.02),
    },
    # met by the two bags that go onto a stop
    'end_cushion': {
        'length': _by_size(0.01, 0.01, 0.015),
        'stiffness': _about(1e3, 1.5e3, 2e3),
        'damping': _about(60.0, 120.0, 200.0),
    },
    # loads of 2 and 5.3 kg ring at 13 to 3 Hz
    'load_compliance': {
        'compliance': _by_size(1e-4, 3e-4, 8e-4),
        'damping': _by_size(6.0, 5.0, 4.0),
    },
    # sensors; the noise is 2e-5 m and 150 Pa
    'position_scale': {'error': _by_size(0.003, 0.01, 0.03)},
    'pressure_offset': {
        'offset_1': _by_size(500.0, 1200.0, 3000.0),
        'offset_2': _by_size(-200.0, 600.0, -1500.0),
    },
    'sensor_delay': {'time_constant': _by_size(0.003, 0.008, 0.025)},
    # at 0.1 bar above atmosphere as much as chamber_leak, at more pressure more
    'porous_leak': {
        'flow_1': _about(6e-7, 8e-7, 2e-6),
        'flow_2': _about(1.2e-6, 1.6e-6, 4e-6),
        'exponent': _by_size(1.1, 1.2, 1.3),
    },
    # gas that was just filled in is some 10 K warmer than the walls
    'natural_convection': {
        'conductance_1': _about(0.3, 0.4, 0.8),
        'conductance_2': _about(0.4, 0.5, 0.8),
        'exponent': _by_size(0.25, 0.25, 0.33),
    },
    # saturates over 0.1 to 2 bar
    'pressure_power_friction': {
        'force': _about(2.0, 4.0, 8.0),
        'exponent': _by_size(0.5, 0.6, 0.7),
    },
    # strokes of one bag are some 0.4 m together, in 14 s
    'travel_dependent_friction': {
        'rate': _by_size(0.2, 0.6, 2.0),
        'limit': _by_size(0.5, 0.5, 0.8),
    },
    'time_dependent_friction': {
        'rate': _by_size(0.007, 0.02, 0.07),
        'limit': _by_size(0.5, 0.5, 0.8),
    },
    # 0.1 to 2 bar between the chambers: 0.1 to 3 N at the ends of the stroke
    'bore_taper': {'taper': _by_size(0.01, 0.03, 0.08)},
    # flows of 2e-5 to 1.4e-4 kg/s in and out of some 2e5 Pa: up to 40 kPa at the fastest
    'line_resistance': {'resistance': _by_size(1e8, 3e8, 9e8)},
    'spool_rate_limit': {'time_per_volt': _by_size(0.01, 0.04, 0.15)},
    # where the strokes of the recordings begin and end
    'local_friction': {
        'share': _by_size(0.1, 0.25, 0.6),
        'place': _by_size(0.4, 0.5, 0.6),
        'width': _by_size(0.15, 0.12, 0.1),
    },
    'direction_dependent_static_friction': {
        'asymmetry': _by_size(0.1, 0.2, 0.4),
        'one_sidedness': _by_size(0.0, 1.0, -1.0),
    },
    # walls of 0.006 to 0.05 m^2: 0.05 to 0.4 W/K at 3 bar, strong 0.5 to 4
    'forced_convection': {
        'coefficient': _by_size(8.0, 25.0, 80.0),
        'exponent': _by_size(0.8, 0.8, 0.5),
    },
    # inflows of 2e-5 to 1.4e-4 kg/s: 0.03 to 0.9 W/K while they last, strong 0.3 to 10
    'jet_convection': {
        'coefficient': _by_size(15.0, 50.0, 160.0),
        'decay_time': _by_size(0.2, 0.4, 0.8),
    },
    # gas of 0.2 to 3 g, 0.7 J/(g K): 0.03 to 0.4 W/K, strong 0.3 to 4
    'gas_mass_heat_transfer': {'rate': _by_size(0.2, 0.6, 2.0)},
    # a full stroke at 2 bar draws 0.35 to 1.5 g: 2 to 7 kPa, strong 20 to 90
    'supply_tank': {'fall': _by_size(5e6, 2e7, 6e7), 'recovery_time': _by_size(3.0, 10.0, 30.0)},
    # at the place two to three times as much as cross_piston_leak
    'local_piston_leak': {
        'area': _about(2e-9, 4e-9, 8e-9),
        'place': _by_size(0.4, 0.5, 0.6),
        'width': _by_size(0.15, 0.12, 0.1),
    },
    # beside 15 to 26 N of static friction
    'seal_elasticity': {'limit': _about(0.15, 0.4, 1.2), 'reach': _by_size(2e-4, 4e-4, 8e-4)},
}
Law = Callable[[dict[str, Any], float], tuple[Changes, Changes]]
"""(section friction, grade 0-2) -> changes of that section in the truth, and in the model."""


def _graded(grade: float, values: tuple[float, ...]) -> float:
    """Return the value at a grade: weak, medium and strong at 0, 1, 2, between them on a line."""
    return float(np.interp(grade, range(len(values)), values))


def _dwell(friction: dict[str, Any], grade: float) -> tuple[Changes, Changes]:
    # F_s grows over the dwells of 0.5-4 s; the slower it does, the less constant F_s is right
    factor = _graded(grade, (2.0, 1.0, 0.5))
    coefficient = factor * friction['dwell_coefficient']
    truth = {'model': 'revised_lugre_dwell', 'dwell_coefficient': coefficient}
    return truth, {'model': 'revised_lugre'}


def _stribeck(friction: dict[str, Any], grade: float) -> tuple[Changes, Changes]:
    share = _graded(grade, (0.1, 0.3, 1.0))
    coulomb = friction['coulomb_force']
    level = coulomb + share * (friction['breakaway_force'] - coulomb)
    truth = {'model': 'lugre', 'breakaway_force': level}
    return truth, {'model': 'coulomb_viscous', 'breakaway_force': level}


def _hysteresis(friction: dict[str, Any], grade: float) -> tuple[Changes, Changes]:
    # beside the springs of the model one more slips at a part of the Coulomb force
    single = sum(friction['element_stiffness'])
    stiffness = _graded(grade, (0.5, 1.0, 2.0)) * single
    limit = _graded(grade, (0.3, 0.5, 0.7)) * friction['coulomb_force']
    truth = {'element_stiffness': [stiffness, single], 'element_limit': [limit]}
    return truth, {'element_stiffness': [single], 'element_limit': []}


def _film(friction: dict[str, Any], grade: float) -> tuple[Changes, Changes]:
    # the film is full at this speed; strokes slip at up to 0.1 m/s
    velocity = _graded(grade, (4.0, 1.0, 0.3)) * friction['film_velocity']
    model = {'model': 'lugre', 'film_velocity': velocity}
    # the lower law has no T: film alone is hidden
    return {**model, 'model': 'revised_lugre', 'fluid_time_constant': 0.0}, model


def _fluid(friction: dict[str, Any], grade: float) -> tuple[Changes, Changes]:
    # acts like a mass sigma_2 T: 0.5, 1.5 and 5 kg
    time = _graded(grade, (0.5, 1.5, 5.0)) / friction['viscous_coefficient']
    return {'fluid_time_constant': time}, {'fluid_time_constant': 0.0}


LAWS: dict[str, Law] = {
    'dwell_static_friction': _dwell,
    'stribeck': _stribeck,
    'presliding_hysteresis': _hysteresis,
    'film_dynamics': _film,
    'fluid_inertia': _fluid,
}
EFFECTS = (*CONTRIBUTIONS, *LAWS)

# the same in the terms of the library: effect -> parameters, from the true section `friction`
LAW_PARAMETERS: dict[str, Callable[[dict[str, Any]], dict[str, float]]] = {
    'dwell_static_friction': lambda f: {
        'lost_share': 1.0,
        'dwell_coefficient': f['dwell_coefficient'],
        'dwell_exponent': f['dwell_exponent'],
    },
    'stribeck': lambda f: {
        'excess': f['breakaway_force'] - f['coulomb_force'],
        'stribeck_velocity': f['stribeck_velocity'],
        'stribeck_exponent': f['stribeck_exponent'],
    },
    'presliding_hysteresis': lambda f: {
        'stiffness': f['element_stiffness'][0],
        'limit': f['element_limit'][0],
    },
    'film_dynamics': lambda f: {
        'growth': 1.0 / f['film_velocity'],
        'time_acceleration': f['film_time_acceleration'],
        'time_deceleration': f['film_time_deceleration'],
        'time_dwell': f['film_time_dwell'],
    },
    'fluid_inertia': lambda f: {'time_constant': f['fluid_time_constant']},
}


def hide(effect: str, cylinder: str, strength: str | float, friction: dict[str, Any]) -> Secret:
    """
    Return what makes an effect missing in the model.

    :param strength: one of ``STRENGTHS``, or a grade between the first, 0, and the last, 2
    :param friction: the shipped section of the cylinder
    """
    grade = float(STRENGTHS.index(strength)) if isinstance(strength, str) else strength
    if effect in LAWS:
        changes = LAWS[effect](friction, grade)
        truth, model = ({f'friction.{key}': one[key] for key in one} for one in changes)
        return Secret({}, truth, model)
    column = CYLINDERS.index(cylinder)
    values = {
        name: _graded(grade, tuple(row[column] for row in rows))
        for name, rows in CONTRIBUTIONS[effect].items()
    }
    return Secret({effect: values}, {}, {})


def true_parameters(effect: str, secret: Secret, friction: dict[str, Any]) -> dict[str, float]:
    """
    Return the true values of an effect's parameters, named as in the library.

    :param friction: the shipped section of the cylinder
    """
    if effect not in LAWS:
        return secret.effects[effect]
    changes = {name.removeprefix('friction.'): value for name, value in secret.truth.items()}
    return LAW_PARAMETERS[effect]({**friction, **changes})
