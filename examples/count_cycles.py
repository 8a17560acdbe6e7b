"""Simulate a stroke of cylinder 1 and count its stick-slip cycles; needs no ROS."""

import numpy as np

from pneu_rig_ros.analysis.motion import find_cycles
from pneu_rig_ros.rig import Rig, load_configuration
from pneu_rig_ros.rig.valve_drive import valve_voltages

COMMAND, DURATION = 0.29, 15.0  # V, s

configuration = load_configuration('cylinder_1', supply_pressure=6e5, seed=3)
rig = Rig(configuration)
voltages = valve_voltages(COMMAND)
count = round(DURATION / rig.interval)
position = np.array([rig.step(*voltages).position for _ in range(count)])

cycles = find_cycles(position, rig.interval)
print(f'{len(cycles)} cycles on {np.ptp(position) * 1e3:.0f} mm')
for cycle in cycles:
    print(
        f'at {cycle.breakaway_time:6.3f} s: '
        f'{cycle.dwell:.3f} s of rest, {cycle.slip * 1e3:.2f} mm of slip'
    )
