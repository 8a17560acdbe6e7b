"""The controller of docs/controllers.md as a reader runs it, beside a simulated plant."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from pneu_rig_ros.nodes.plant import PlantNode
from pneu_rig_ros.nodes.valve_command import ValveCommandNode
from pneu_rig_ros.records.cdr_decoding import unpack_joint_state

from .bystander import gather

pytestmark = pytest.mark.live

NEAR = 1.5e-3
"""Without an integral it stops where u is within the valves' overlap: 0.15 V / (200 V/m) [m]."""

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / 'examples' / 'own_controller.py'


@pytest.fixture
def controller():
    process = subprocess.Popen([sys.executable, str(EXAMPLE)], stderr=subprocess.PIPE, text=True)
    yield process
    process.kill()
    process.communicate()


def test_it_is_short():
    code = EXAMPLE.read_text().split('\n\n', 1)[1]
    assert len([line for line in code.splitlines() if line.strip()]) <= 20


@pytest.mark.parametrize(
    'cylinder', [pytest.param('cylinder_1', marks=pytest.mark.long), 'cylinder_2']
)
def test_it_takes_the_piston_to_its_target(context, bystander, loop_of, controller, cylinder):
    simulated = {'use_sim_time': True}
    plant = {**simulated, 'speed': 2.0, 'cylinder': cylinder, 'initial_position': 0.07}
    samples = bystander.hear('joint_states')
    valves = ValveCommandNode(context, {**simulated, 'command_timeout': 0.0})
    runner = loop_of(PlantNode(context, plant), valves)
    commands = bystander.hear('u')
    start = gather(runner, [samples], 1)[0][0]
    gather(runner, [commands], 1)  # until the controller has found the rig
    positions = []
    while len(positions) < 5 and not (positions and abs(positions[-1] - 0.1) < NEAR):
        heard = gather(runner, [samples], 3000)[0]  # the controller may get its turn late
        positions.append(unpack_joint_state(heard[-1]).position)
    assert unpack_joint_state(start).position == pytest.approx(0.07, abs=1e-3)
    assert positions[-1] == pytest.approx(0.1, abs=NEAR), positions
    assert controller.poll() is None
    controller.send_signal(signal.SIGINT)
    _, errors = controller.communicate(timeout=30)
    assert controller.returncode == 0, errors
    # Python also reports an interrupt within a destructor of rclpy, which is not the example's
    assert EXAMPLE.name not in errors, errors
