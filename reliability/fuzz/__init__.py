"""Bad input for every reader: property-based, guided by coverage, and damage to bags."""

from reliability.fuzz.command import fuzz

__all__ = ['fuzz']
