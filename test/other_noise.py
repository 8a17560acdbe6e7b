"""Other noise from the same seeds, to see whether a test rests on that of one of them."""

from collections.abc import Sequence

import numpy as np

Seed = int | Sequence[int] | None


def draw_other_noise(number: int) -> None:
    """Let NumPy's generators draw other normal numbers from each seed; all else stays."""

    class Generator(np.random.Generator):
        def __init__(self, seed: Seed = None) -> None:
            super().__init__(np.random.PCG64(seed))
            noise = None if seed is None else [number, *np.atleast_1d(seed)]
            other = np.random.Generator(np.random.PCG64(noise))
            self.normal, self.standard_normal = other.normal, other.standard_normal

    np.random.default_rng = Generator
