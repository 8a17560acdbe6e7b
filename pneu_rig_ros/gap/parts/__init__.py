"""Diagnosis of a part of a rig alone: its chambers, its friction, its valves."""
