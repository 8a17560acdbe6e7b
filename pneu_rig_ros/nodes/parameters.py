"""ROS parameters declared from tables: name, default, description, unit and range of each."""

import math
from collections.abc import Iterable
from typing import NamedTuple

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import ParameterException
from rclpy.node import Node

from pneu_rig_ros.errors import RigError


class Parameter(NamedTuple):
    """
    One parameter of a node.

    :param default: its type is the type of the parameter
    :param unit: SI unit, empty for texts and flags
    :param low: smallest allowed number [unit]
    :param high: largest allowed number [unit]
    :param choices: allowed names; empty for any text
    :param constraint: what else its value must be
    :param read_only: whether it is fixed while the node runs
    """

    name: str
    default: bool | int | float | str
    description: str
    unit: str = ''
    low: float = -math.inf
    high: float = math.inf
    choices: tuple[str, ...] = ()
    read_only: bool = True
    constraint: str = ''

    @property
    def names(self) -> str:
        """The choices as text."""
        return ', '.join(choice or "''" for choice in self.choices)

    @property
    def allowed(self) -> str:
        """The constraints besides type and range; '' without any."""
        return f'one of {self.names}' if self.choices else self.constraint

    def descriptor(self) -> ParameterDescriptor:
        """Return the descriptor, by which ROS tools show the parameter and rclpy checks it."""
        descriptor = ParameterDescriptor(
            description=self.description + (f' [{self.unit}]' if self.unit else ''),
            additional_constraints=self.allowed,
            read_only=self.read_only,
        )
        if math.isfinite(self.low) and math.isfinite(self.high):
            if isinstance(self.default, float):
                limits = FloatingPointRange(from_value=self.low, to_value=self.high)
                descriptor.floating_point_range = [limits]
            else:
                whole = IntegerRange(from_value=int(self.low), to_value=int(self.high), step=1)
                descriptor.integer_range = [whole]
        return descriptor


def declare(node: Node, table: Iterable[Parameter]) -> None:
    """
    Declare the parameters of a table.

    :raises RigError: when a value given at the start has a wrong type or is out of range
    """
    for parameter in table:
        where = f'{node.get_name()}: parameter {parameter.name}'
        try:
            value = node.declare_parameter(
                parameter.name, parameter.default, parameter.descriptor()
            ).value
        except ParameterException as error:
            raise RigError(f'{where}: {error}') from error
        if parameter.choices and value not in parameter.choices:
            raise RigError(f'{where}: {value!r}, allowed {parameter.names}')
