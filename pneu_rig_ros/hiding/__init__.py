"""An effect is hidden in the rig and looked for: recorded over ROS 2, diagnosed, revealed."""
