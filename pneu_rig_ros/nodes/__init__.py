"""The rig on ROS 2: thin nodes around the plant, the valve drive, Eq. 2 and the bag writer."""

import os

from pneu_rig_ros.rig.configuration import configuration_folder

OWNER = 'PNEU_RIG_OWNER'
"""Environment variable: number of the process without which a node does not go on."""

PROFILES = 'FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE'
"""Where Fast DDS looks for its settings; the second since Kilted."""

if not any(name in os.environ for name in PROFILES):
    os.environ |= dict.fromkeys(PROFILES, str(configuration_folder() / 'fastdds.xml'))
