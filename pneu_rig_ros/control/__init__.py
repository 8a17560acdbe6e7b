"""Commands for the rig without ROS: excitations, position control, and a model run beside it."""
