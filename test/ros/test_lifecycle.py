"""The managed nodes through all transitions, as `ros2 lifecycle` asks for them."""

import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.context import Context

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.nodes.friction_estimator import FrictionEstimatorNode
from pneu_rig_ros.nodes.plant import PlantNode
from pneu_rig_ros.nodes.recorder import RecorderNode
from pneu_rig_ros.nodes.runner import Runner
from pneu_rig_ros.nodes.shadow import ShadowNode
from pneu_rig_ros.nodes.valve_command import ValveCommandNode
from pneu_rig_ros.records import read_recording
from pneu_rig_ros.records.cdr_decoding import unpack_joint_state, unpack_valve_voltages
from pneu_rig_ros.records.cdr_encoding import pack_float64

from .bystander import Bystander, gather

pytestmark = pytest.mark.live

BY_HAND = {'autostart': False}
Make = Callable[..., 'Managed']


class Managed:
    """Nodes in a loop, and a client of their transitions."""

    def __init__(self, client: Bystander, runner: Runner) -> None:
        self.runner = runner
        self._client = client

    def state(self, node: str) -> str:
        answer = self._client.call(self.runner, GetState, f'{node}/get_state')
        return str(answer.current_state.label)

    def change(self, node: str, *labels: str) -> bool:
        """Ask for transitions; return whether the last one succeeded."""
        for label in labels:
            service, transition = f'{node}/change_state', Transition(label=label)
            answer = self._client.call(self.runner, ChangeState, service, transition=transition)
        return bool(answer.success)


@pytest.fixture
def managed(bystander: Bystander, loop_of: Callable[..., Runner]) -> Make:
    return lambda *nodes: Managed(bystander, loop_of(*nodes))


@pytest.mark.parametrize(
    'kind', [PlantNode, ValveCommandNode, FrictionEstimatorNode, RecorderNode, ShadowNode]
)
def test_every_node_goes_all_ways(
    kind: type[Any],
    context: Context,
    managed: Make,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    node = kind(context, BY_HAND)
    rig, name = managed(node), node.get_name()
    assert rig.state(name) == 'unconfigured'
    assert not list(node.polled_subscriptions)
    for labels, state in (
        (['configure'], 'inactive'),
        (['activate'], 'active'),
        (['deactivate'], 'inactive'),
        (['cleanup'], 'unconfigured'),
        (['configure', 'activate', 'deactivate', 'activate'], 'active'),
    ):
        assert rig.change(name, *labels)
        assert rig.state(name) == state
    assert node.full_status().state != 'inactive'
    assert rig.change(name, 'shutdown')
    assert rig.state(name) == 'finalized'
    assert node.full_status().state == 'inactive'


def test_simple_start_is_active_at_once(context: Context, managed: Make) -> None:
    assert managed(ValveCommandNode(context)).state('valve_command') == 'active'


def test_plant_is_silent_until_active_and_goes_on_with_later_stamps(
    context: Context, bystander: Bystander, managed: Make
) -> None:
    samples = bystander.hear('joint_states')
    rig = managed(PlantNode(context, BY_HAND))
    rig.change('plant', 'configure')
    assert samples.take() is None
    rig.change('plant', 'activate')
    first = unpack_joint_state(gather(rig.runner, [samples], 100)[0][-1])
    rig.change('plant', 'deactivate')
    before = [unpack_joint_state(cdr).stamp_ns for cdr in samples.take_all()]
    assert rig.state('plant') == 'inactive'
    assert samples.take() is None
    rig.change('plant', 'activate')
    again = [unpack_joint_state(cdr).stamp_ns for cdr in gather(rig.runner, [samples], 100)[0]]
    assert again[0] > max(before, default=first.stamp_ns)
    assert {b - a for a, b in pairwise(again)} == {1_160_000}


def test_deactivated_valve_command_shuts_the_valves(
    context: Context, bystander: Bystander, managed: Make
) -> None:
    voltages = bystander.hear('valve_voltages')
    rig = managed(ValveCommandNode(context, {'command_timeout': 0.0}))
    bystander.speak('u')(pack_float64(1.0))
    opened = unpack_valve_voltages(gather(rig.runner, [voltages], 1)[0][0])
    assert opened[0] > 3.0
    rig.change('valve_command', 'deactivate')
    shut = unpack_valve_voltages(gather(rig.runner, [voltages], 1)[0][0])
    assert all(math.isclose(voltage, 2.5, abs_tol=5e-3) for voltage in shut)


def test_recorder_active_first_loses_nothing_and_makes_a_bag_each_time(
    context: Context, managed: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    plant, recorder = PlantNode(context, BY_HAND), RecorderNode(context, BY_HAND)
    rig = managed(plant, recorder)
    rig.change('recorder', 'configure', 'activate')
    rig.change('plant', 'configure', 'activate')
    rig.runner.run(lambda: plant.rate.count < 500)
    rig.change('plant', 'deactivate')
    rig.change('recorder', 'deactivate', 'cleanup')
    (bag,) = (tmp_path / 'runs').iterdir()
    recording = read_recording(bag)
    assert recording.size == plant.rate.count
    assert not any(stamps.size for stamps in recording.missing.values())


def test_node_that_cannot_be_configured_stays_and_says_why(
    context: Context, managed: Make, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    given = {'output': str(tmp_path)}
    with pytest.raises(RigError, match='exists'):
        RecorderNode(context, given)
    rig = managed(RecorderNode(context, {**given, **BY_HAND}))
    assert not rig.change('recorder', 'configure')
    assert rig.state('recorder') == 'unconfigured'
    assert 'exists; name a bag that does not' in capfd.readouterr().err
