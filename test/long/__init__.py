"""Tests that take minutes to an hour: soak, faults, damaged input, random rigs, scale."""
