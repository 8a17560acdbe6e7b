"""The whole rig in one process: plant, valve command, friction estimator and recorder."""

from functools import partial

from pneu_rig_ros.nodes import runner
from pneu_rig_ros.nodes.friction_estimator import FrictionEstimatorNode
from pneu_rig_ros.nodes.plant import PlantNode
from pneu_rig_ros.nodes.recorder import RecorderNode
from pneu_rig_ros.nodes.valve_command import ValveCommandNode

NODES = (PlantNode, ValveCommandNode, FrictionEstimatorNode, RecorderNode)
"""The timer of the plant is that of the loop."""

main = partial(runner.main, NODES)

if __name__ == '__main__':
    raise SystemExit(main())
