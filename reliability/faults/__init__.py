"""Faults: what is done to the rig, what it has to do then, what it says, what was measured."""
