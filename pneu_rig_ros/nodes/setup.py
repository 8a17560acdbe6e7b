"""The rig that a node's parameters describe."""

from dataclasses import replace

from rclpy.node import Node

from pneu_rig_ros.nodes import parameters
from pneu_rig_ros.nodes.parameters import Parameter
from pneu_rig_ros.rig import Rig, RigConfiguration, load_configuration
from pneu_rig_ros.rig.configuration import OVERRIDES

SET_AT_RUN_TIME = {'supply_pressure': Rig.set_supply_pressure, 'load_mass': Rig.set_load_mass}
"""Quantities that may change while the rig runs, and how."""

OF_CYLINDER = '; of the cylinder when left alone'

PARAMETERS = (
    Parameter('cylinder', 'cylinder_2', 'name of a shipped cylinder, or a YAML file'),
    Parameter('friction', '', f'friction model{OF_CYLINDER}'),
    Parameter('sensors', '', f"'rig' or 'ideal' sensors{OF_CYLINDER}"),
    Parameter('seed', -1, 'seed of noise and calibration; -1: of the cylinder', '-', -1, 2**53),
    Parameter('interval_ns', 0, 'sampling interval; 0: of the cylinder', 'ns', 0, 10**9),
)


def declare_setup(node: Node) -> None:
    """
    Declare PARAMETERS, then the quantities whose defaults and ranges the cylinder brings along.

    :raises RigError: when a value is not usable
    """
    parameters.declare(node, PARAMETERS)
    operation = load_configuration(parameters.text(node, 'cylinder')).model.operation
    parameters.declare(
        node,
        (
            Parameter(
                name,
                float(getattr(operation, name)),
                quantity.description,
                quantity.unit,
                quantity.low,
                quantity.high,
                read_only=name not in SET_AT_RUN_TIME,
            )
            for name, quantity in OVERRIDES.items()
        ),
    )


def read_setup(node: Node) -> RigConfiguration:
    """Return the configuration that the declared parameters describe. RigError if it is none."""
    seed = int(parameters.number(node, 'seed'))
    configuration = load_configuration(
        parameters.text(node, 'cylinder'),
        seed=None if seed < 0 else seed,
        sensors=parameters.text(node, 'sensors') or None,
        friction=parameters.text(node, 'friction') or None,
        **{name: parameters.number(node, name) for name in OVERRIDES},
    )
    interval_ns = int(parameters.number(node, 'interval_ns')) or configuration.interval_ns
    return replace(configuration, interval_ns=interval_ns)
