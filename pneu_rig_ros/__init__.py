"""Emulated pneumatic servo rig for ROS 2."""
