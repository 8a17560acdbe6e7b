"""The cylinder for RViz and Foxglove: a URDF whose joint `piston` moves with `joint_states`."""

import math
from string import Template
from xml.sax.saxutils import escape

from pneu_rig_ros.rig.configuration import RigConfiguration
from pneu_rig_ros.rig.yaml_file import configuration_folder

WALL, CAP_LENGTH, PISTON_LENGTH, ROD_BEYOND = 0.003, 0.012, 0.02, 0.06
"""
For the picture [m]: thickness of the tube; lengths of the end caps, of the piston, and of the rod
outside the cylinder when the piston is in.
"""
DENSITY = 7850.0
"""Of the load, steel, for its size [kg/m^3]."""
FASTEST = 3.0
"""Bound on the speed, which URDF wants [m/s]."""


def robot_description(configuration: RigConfiguration) -> str:
    """
    Return the URDF of a rig's cylinder, lengths in m.

    Joint `piston` is prismatic along x from 0 to the stroke; 0 is the cap end.
    """
    template = (configuration_folder() / 'cylinder.urdf.xml').read_text(encoding='utf-8')
    return Template(template).substitute(_values(configuration))


def controlled_description(configuration: RigConfiguration, namespace: str) -> str:
    """
    Return the URDF with the `<ros2_control>` tag of `config/ros2_control.urdf.xml`.

    :param namespace: of the rig, '' for none
    """
    template = (configuration_folder() / 'ros2_control.urdf.xml').read_text(encoding='utf-8')
    name = escape(namespace.strip('/'))
    tag = Template(template).substitute(prefix=f'/{name}' if name else '')
    return robot_description(configuration).replace('</robot>', f'{tag}</robot>')


def _values(configuration: RigConfiguration) -> dict[str, str]:
    cylinder, operation = configuration.model.cylinder, configuration.model.operation
    bore = cylinder.bore
    tube = cylinder.stroke + PISTON_LENGTH
    load = (max(operation.load_mass, 1e-3) / DENSITY) ** (1.0 / 3.0)
    rod = tube + ROD_BEYOND
    force = operation.supply_pressure * cylinder.cap_area
    numbers = {
        'stroke': cylinder.stroke,
        'effort': force,
        'velocity': FASTEST,
        'moving_mass': cylinder.moving_mass,
        'tube_length': tube,
        'tube_middle': 0.5 * tube,
        'tube_radius': 0.5 * bore + WALL,
        'cap_length': CAP_LENGTH,
        'cap_end': -0.5 * CAP_LENGTH,
        'rod_end': tube + 0.5 * CAP_LENGTH,
        'cap_width': bore + 4.0 * WALL,
        'piston_length': PISTON_LENGTH,
        'piston_middle': 0.5 * PISTON_LENGTH,
        'piston_radius': 0.5 * bore,
        'rod_length': rod,
        'rod_middle': 0.5 * rod,
        'rod_radius': 0.5 * cylinder.rod_diameter,
        'load_size': load,
        'load_middle': rod + 0.5 * load,
        'inertia': cylinder.moving_mass * (0.25 * bore**2 + rod**2) / 12.0,
    }
    assert all(math.isfinite(number) for number in numbers.values())
    return {
        'name': escape(configuration.name, {'"': '&quot;'}),
        **{key: f'{x:.9g}' for key, x in numbers.items()},
    }
