"""The rig on ROS 2: thin nodes around the plant, the valve drive, Eq. 2 and the bag writer."""

OWNER = 'PNEU_RIG_OWNER'
"""Environment variable: number of the process without which a node does not go on."""
