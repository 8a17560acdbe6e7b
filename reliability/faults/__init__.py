"""Faults: what is done to the rig, what it has to do then, what it says, what was measured."""

from reliability.faults.command import faults

__all__ = ['faults']
