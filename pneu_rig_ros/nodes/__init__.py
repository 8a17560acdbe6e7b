"""The rig on ROS 2: thin nodes around the plant, the valve drive, Eq. 2 and the bag writer."""
