"""Friction force of a bag by Eq. 2: `python friction_of_a_bag.py BAG`; needs no ROS."""

import sys

import numpy as np

from pneu_rig_ros.analysis.friction import ForceBalance, friction_zero_phase
from pneu_rig_ros.analysis.motion import find_cycles
from pneu_rig_ros.records import read_recording
from pneu_rig_ros.rig import load_configuration

record = read_recording(sys.argv[1])
configuration = record.configuration or load_configuration('cylinder_2')
friction = friction_zero_phase(
    record.position,
    record.pressure_1,
    record.pressure_2,
    record.interval,
    ForceBalance.of(configuration),
)
peaks = [c.peak_friction for c in find_cycles(record.position, record.interval, friction)]
print(f'{configuration.name}: mean {np.mean(friction):.2f} N, largest {np.max(friction):.2f} N')
print('peaks of the cycles [N]:', ' '.join(f'{peak:.2f}' for peak in peaks) or 'none')
