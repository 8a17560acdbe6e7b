"""A rig made from docs/own_rig.md by its letter: its file, topics, conditions and commands."""

import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from rclpy.context import Context
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64, Header

from pneu_rig_ros.cli import main
from pneu_rig_ros.nodes.diagnostics import NodeStatus
from pneu_rig_ros.nodes.friction_estimator import FrictionEstimatorNode
from pneu_rig_ros.nodes.recorder import RecorderNode
from pneu_rig_ros.nodes.rig_node import RigNode
from pneu_rig_ros.nodes.runner import Runner
from pneu_rig_ros.nodes.shadow import ShadowNode
from pneu_rig_ros.nodes.valve_command import ValveCommandNode
from pneu_rig_ros.rig import Rig, load_configuration
from pneu_rig_ros.rig.valve_drive import valve_voltages

from .bystander import Bystander

pytestmark = pytest.mark.live

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / 'docs' / 'own_rig.md').read_text()
BLOCKS = dict(re.findall(r'^```yaml\n((\w+):.*?)^```$', PAGE, re.MULTILINE | re.DOTALL))
SECTIONS, CONDITIONS = (
    next(text for text, first in BLOCKS.items() if first == word)
    for word in ('sensors', 'supply_pressure')
)
KINDS: dict[str, type[RigNode]] = {
    'recorder': RecorderNode,
    'friction_estimator': FrictionEstimatorNode,
    'shadow': ShadowNode,
}
U, INTERVAL_NS, SAMPLES, AT_ONCE = 0.34, 1_000_000, 5000, 20


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the working directory, with the copy of the configuration that the page wants."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(ROOT / 'config' / 'cylinder_2.yaml', 'my_cylinder.yaml')
    return tmp_path


def parameters(node: str) -> dict[str, Any]:
    """Return those of a node in the commands of the page."""
    (line,) = re.findall(rf'^ros2 run pneu_rig_ros {node} --ros-args(.*)$', PAGE, re.MULTILINE)
    given = dict(re.findall(r'-p (\w+):=(\S+)', line))
    return {name: float(v) if v[0].isdigit() else v for name, v in given.items()}


class Driver(Bystander):
    """The driver of a rig that samples at 1 kHz, as its owner writes it."""

    def __init__(self, context: Context, samples: int) -> None:
        super().__init__(context)
        qos = qos_profile_sensor_data
        self._joints = self.create_publisher(JointState, 'joint_states', qos)
        self._pressures = [
            self.create_publisher(FluidPressure, f'chamber_{n}/pressure', qos) for n in (1, 2)
        ]
        self._command = self.create_publisher(Float64, 'u', qos)
        self._rig = Rig(replace(load_configuration('cylinder_2'), interval_ns=INTERVAL_NS))
        self.sent, self._samples = 0, samples

    def publish_sample(self) -> None:
        sample = self._rig.step(*valve_voltages(U))
        self.sent += 1
        header = Header(stamp=Time(nanoseconds=self.sent * INTERVAL_NS).to_msg())
        names, position, velocity = ['piston'], [sample.position], [sample.velocity]
        self._joints.publish(
            JointState(header=header, name=names, position=position, velocity=velocity)
        )
        pressures = sample.pressure_1, sample.pressure_2
        for publisher, pressure in zip(self._pressures, pressures, strict=True):
            publisher.publish(FluidPressure(header=header, fluid_pressure=pressure))

    def work(self) -> bool:
        """Publish what is due, once the nodes are there; return whether the run goes on."""
        publishers = self._joints, *self._pressures
        if min(each.get_subscription_count() for each in publishers) < len(KINDS):
            return True
        self._command.publish(Float64(data=U))
        for _ in range(AT_ONCE):
            self.publish_sample()
        return self.sent < self._samples


def run(context: Context, samples: int = SAMPLES) -> dict[str, NodeStatus]:
    """Run the nodes of the page beside the driver; return what they report."""
    nodes = [kind(context, parameters(name)) for name, kind in KINDS.items()]
    runner = Runner([*nodes, ValveCommandNode(context)])
    driver = Driver(context, samples)
    runner.run(driver.work)
    for node in nodes:
        node.update()
    status = {node.get_name(): node.full_status() for node in nodes}
    runner.close()
    driver.destroy_node()
    return status


def test_rig_of_the_page_works(
    folder: Path, context: Context, capsys: pytest.CaptureFixture[str]
) -> None:
    with (folder / 'my_cylinder.yaml').open('a') as file:
        file.write(SECTIONS)
    status = run(context)
    assert (
        status['friction_estimator'].values['published'] > SAMPLES / 2
    )  # until it is discovered, they are lost
    assert status['shadow'].values['restarts'] > 0
    assert not any('grid' in one.message for one in status.values())
    (folder / 'runs' / 'monday' / 'conditions.yaml').write_text(CONDITIONS)
    compare = ['compare', 'runs/monday', '--model', 'my_cylinder.yaml', '--out', 'page.html']
    assert main(compare) == 0, capsys.readouterr().err
    assert 'rest time 1200 s' in capsys.readouterr().out


def test_wrong_interval_is_reported(folder: Path, context: Context) -> None:
    """The copy as it is has the 1.16 ms of the paper."""
    status = run(context, SAMPLES // 4)
    for name in ('friction_estimator', 'shadow'):
        assert 'samples are 1 ms apart' in status[name].message
