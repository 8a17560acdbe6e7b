"""Other noise from the same seeds, to see whether a test rests on that of one of them."""

from collections.abc import Sequence
from typing import Any

import numpy as np


class OtherNoise(np.random.Generator):
    """
    Draws other normal numbers than NumPy from a seed, also after a spawn, and all else as it does.

    :param number: which normal numbers
    """

    def __init__(self, seed: int | Sequence[int], number: int) -> None:
        super().__init__(np.random.PCG64(seed))
        noise = np.random.Generator(np.random.PCG64([number, *np.atleast_1d(seed)]))
        self.normal, self.standard_normal = noise.normal, noise.standard_normal
        self.spawn = noise.spawn


def draw_other_noise(number: int) -> None:
    """Give out such generators for all seeds that are numbers."""
    own = np.random.default_rng

    def other(seed: Any = None) -> np.random.Generator:
        numbers = isinstance(seed, (int, np.integer, list, tuple))
        return OtherNoise(seed, number) if numbers else own(seed)

    np.random.default_rng = other
