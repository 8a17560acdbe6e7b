"""The paper's system-level model: valves, chambers, piston and friction, compiled."""
