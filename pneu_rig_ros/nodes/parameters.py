"""ROS parameters declared from a table: default, unit, range, what it is, fixed or not."""

import math
from collections.abc import Iterable
from typing import NamedTuple

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import ParameterException
from rclpy.node import Node

from pneu_rig_ros.errors import RigError

Value = bool | int | float | str


class Parameter(NamedTuple):
    """
    One parameter of a node.

    :param default: its type is the type of the parameter
    :param unit: SI unit, empty for names and switches
    :param low: smallest allowed number [unit]
    :param high: largest allowed number [unit]
    :param choices: allowed names; empty for any text
    :param read_only: whether it is fixed once the node runs
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
        """Return what ROS tools show of the parameter and check of its values."""
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


def switch(node: Node, name: str) -> bool:
    """Return a declared switch."""
    return bool(node.get_parameter(name).value)
