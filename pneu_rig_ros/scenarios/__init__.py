"""Scenarios: experiments on a rig, and what can be hidden in it, how strong."""
