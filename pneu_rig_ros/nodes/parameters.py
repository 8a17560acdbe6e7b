"""ROS parameters from tables: default, unit, range, description; those of the rig."""

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import ParameterException
from rclpy.node import Node

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.rig import Rig, RigConfiguration, load_configuration
from pneu_rig_ros.rig.configuration import OVERRIDES

Value = bool | int | float | str


class Parameter(NamedTuple):
    """
    One parameter of a node.

    :param default: its type is the type of the parameter
    :param unit: SI unit, empty for texts and flags
    :param low: smallest allowed number [unit]
    :param high: largest allowed number [unit]
    :param choices: allowed names; empty for any text
    :param read_only: whether it is fixed while the node runs
    """

    name: str
    default: Value
    description: str
    unit: str = ''
    low: float = -math.inf
    high: float = math.inf
    choices: tuple[str, ...] = ()
    read_only: bool = True

    def descriptor(self) -> ParameterDescriptor:
        """Return the descriptor, by which ROS tools show the parameter and rclpy checks it."""
        unit = f' [{self.unit}]' if self.unit else ''
        descriptor = ParameterDescriptor(
            description=f'{self.description}{unit}',
            additional_constraints=f'one of {", ".join(self.choices)}' if self.choices else '',
            read_only=self.read_only,
        )
        if math.isfinite(self.low) and math.isfinite(self.high):
            self._limit(descriptor)
        return descriptor

    def _limit(self, descriptor: ParameterDescriptor) -> None:
        if isinstance(self.default, float):
            limits = FloatingPointRange(from_value=self.low, to_value=self.high)
            descriptor.floating_point_range = [limits]
        else:
            whole = IntegerRange(from_value=int(self.low), to_value=int(self.high), step=1)
            descriptor.integer_range = [whole]


RUNTIME_SETTERS = {'supply_pressure': Rig.set_supply_pressure, 'load_mass': Rig.set_load_mass}
"""Quantities that may change while the rig runs, and the methods that set them."""

RIG_PARAMETERS = (
    Parameter('cylinder', 'cylinder_2', 'name of a shipped cylinder, or a YAML file'),
    Parameter('friction', '', 'friction model; empty: that of the cylinder'),
    Parameter('sensors', '', "'rig' or 'ideal' sensors; empty: those of the cylinder"),
    Parameter('seed', -1, 'seed of noise and calibration; -1: of the cylinder', '-', -1, 2**53),
    Parameter('interval_ns', 0, 'sampling interval; 0: that of the cylinder', 'ns', 0, 10**9),
)


def declare(node: Node, table: Iterable[Parameter]) -> None:
    """
    Declare the parameters of a table.

    :raises RigError: when a value given at the start has a wrong type or is out of range
    """
    for parameter in table:
        try:
            value = node.declare_parameter(
                parameter.name, parameter.default, parameter.descriptor()
            ).value
        except ParameterException as error:
            raise RigError(f'{node.get_name()}: parameter {parameter.name}: {error}') from error
        if parameter.choices and value not in parameter.choices:
            raise RigError(
                f'{node.get_name()}: parameter {parameter.name}: {value!r}, '
                f'allowed {", ".join(parameter.choices)}'
            )


def number(node: Node, name: str) -> float:
    """Return a declared number."""
    return float(node.get_parameter(name).value)


def text(node: Node, name: str) -> str:
    """Return a declared text."""
    return str(node.get_parameter(name).value)


def flag(node: Node, name: str) -> bool:
    """Return a declared parameter that is true or false."""
    return bool(node.get_parameter(name).value)


def declare_rig_parameters(node: Node) -> None:
    """
    Declare RIG_PARAMETERS, then the quantities whose defaults come from the cylinder.

    :raises RigError: when a value has a wrong type or is out of range
    """
    declare(node, RIG_PARAMETERS)
    operation = load_configuration(text(node, 'cylinder')).model.operation
    declare(
        node,
        (
            Parameter(
                name,
                float(getattr(operation, name)),
                quantity.description,
                quantity.unit,
                quantity.low,
                quantity.high,
                read_only=name not in RUNTIME_SETTERS,
            )
            for name, quantity in OVERRIDES.items()
        ),
    )


def rig_configuration(node: Node) -> RigConfiguration:
    """Return the configuration of the declared parameters; RigError if it is not valid."""
    seed = int(number(node, 'seed'))
    configuration = load_configuration(
        text(node, 'cylinder'),
        seed=None if seed < 0 else seed,
        sensors=text(node, 'sensors') or None,
        friction=text(node, 'friction') or None,
        **{name: number(node, name) for name in OVERRIDES},
    )
    interval_ns = int(number(node, 'interval_ns')) or configuration.interval_ns
    return replace(configuration, interval_ns=interval_ns)
