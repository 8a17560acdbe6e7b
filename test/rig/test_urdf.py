"""The URDF of each cylinder, read by a URDF library."""

import io
from dataclasses import replace

import numpy as np
import pytest
from yourdfpy import URDF

from pneu_rig_ros.records.topics import PISTON
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.rig.urdf import robot_description
from pneu_rig_ros.rig.yaml_file import shipped


def read(text: str) -> URDF:
    return URDF.load(io.BytesIO(text.encode()), build_scene_graph=True)


@pytest.mark.parametrize('name', shipped('cylinder_*.yaml'))
def test_joint_moves_the_rod_along_the_stroke(name: str) -> None:
    configuration = load_configuration(name, load_mass=2.0)
    robot = read(robot_description(configuration))
    assert robot.validate()
    assert robot.actuated_joint_names == [PISTON]
    joint = robot.joint_map[PISTON]
    stroke = configuration.model.cylinder.stroke
    assert joint.type == 'prismatic'
    assert (joint.limit.lower, joint.limit.upper) == (0.0, pytest.approx(stroke))
    places = []
    for position in (0.0, stroke):
        robot.update_cfg({PISTON: position})
        places.append(robot.get_transform('rod', 'base')[:3, 3])
    assert places[1] - places[0] == pytest.approx(np.array([stroke, 0.0, 0.0]))
    mass = robot.link_map['rod'].inertial.mass
    assert mass == pytest.approx(configuration.model.cylinder.moving_mass)


def test_piston_stays_inside_the_tube_and_fits_it() -> None:
    configuration = load_configuration('cylinder_3')
    robot = read(robot_description(configuration))
    tube = next(v for v in robot.link_map['cylinder'].visuals if v.name == 'tube')
    piston = next(v for v in robot.link_map['head'].visuals if v.name == 'piston')
    length = piston.geometry.cylinder.length + configuration.model.cylinder.stroke
    assert tube.geometry.cylinder.length == pytest.approx(length)
    assert piston.geometry.cylinder.radius < tube.geometry.cylinder.radius
    assert 2.0 * piston.geometry.cylinder.radius == pytest.approx(
        configuration.model.cylinder.bore
    )


def test_a_link_has_one_colour() -> None:
    """RViz 2 paints all of a link in its first (ros2/rviz issue 1293)."""
    robot = read(robot_description(load_configuration('cylinder_1')))
    for link in robot.link_map.values():
        assert len({visual.material.name for visual in link.visuals}) <= 1


def test_a_hostile_name_stays_a_name() -> None:
    name = '"><robot name="x$stroke & <!--'
    configuration = replace(load_configuration('cylinder_1'), name=name)
    assert read(robot_description(configuration)).robot.name == name
