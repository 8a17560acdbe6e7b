"""Scale: same results on any number of workers, what a killed one costs, and what a trial."""

from reliability.scale.command import scale

__all__ = ['scale']
