"""
Where a hidden contribution exceeds the noise, and how far told intervals agree with that.

A window is the test function of a residual in weak form: the contribution is averaged with it, and
the noise of the sensors goes through its derivatives in closed form.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

LEAST_SAMPLES = 20
GAS_WINDOW, FORCE_WINDOW = 0.1, 0.07
"""[s]"""
Interval = tuple[float, float]


class Window(NamedTuple):
    """
    A test function of a length [s] with an integral of 1, sampled at an interval [s].

    :param order: power of the sine that it is: 2 (Hann) or 4
    """

    length: float
    interval: float
    order: int

    @property
    def weights(self) -> np.ndarray:
        """Share that each sample has in an average, odd in number."""
        half = round(0.5 * self.length / self.interval)
        phase = np.pi * (np.arange(-half, half + 1) * self.interval / self.length + 0.5)
        weights = np.sin(np.clip(phase, 0.0, np.pi)) ** self.order
        return weights / weights.sum()

    def average(self, values: np.ndarray) -> np.ndarray:
        """Return the average around each sample; beyond the ends all is zero."""
        weights = self.weights
        padded = np.pad(values, len(weights) // 2)
        return np.convolve(padded, weights, 'valid')

    def noise(self, derivative: int) -> float:
        """
        Return the standard deviation of a derivative of white noise of 1 in the window.

        The sum over samples of the squared derivative of the test function, as an integral.
        """
        return float(
            np.sqrt(
                self.interval
                * _SQUARES[self.order, derivative]
                / self.length ** (2 * derivative + 1)
            )
        )


_SQUARES = {
    (2, 0): 1.5,
    (2, 1): 2.0 * np.pi**2,
    (4, 0): 35.0 / 18.0,
    (4, 2): 256.0 * np.pi**4 / 9.0,
}
"""(power of the sine, derivative) -> integral of its square, for a window of length 1."""


def gas_window(interval: float) -> Window:
    """Return the window in which the balance of a gas is looked at."""
    return Window(max(GAS_WINDOW, LEAST_SAMPLES * interval), interval, 2)


def force_window(interval: float) -> Window:
    """Return the window in which the balance of forces is looked at."""
    return Window(max(FORCE_WINDOW, LEAST_SAMPLES * interval), interval, 4)


def exceeds(contribution: np.ndarray, window: Window, noise: np.ndarray | float) -> np.ndarray:
    """Return at which samples a contribution, averaged, exceeds one standard deviation."""
    return np.abs(window.average(contribution)) > noise


def intervals(mask: np.ndarray, interval: float) -> list[Interval]:
    """Return from, to [s] of each run of true samples."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return [(float(a * interval), float(b * interval)) for a, b in edges.reshape(-1, 2)]


def merged(told: Iterable[Interval]) -> list[Interval]:
    """Return the union of intervals, in order."""
    union: list[Interval] = []
    for start, end in sorted(told):
        if union and start <= union[-1][1]:
            union[-1] = union[-1][0], max(union[-1][1], end)
        elif end > start:
            union.append((start, end))
    return union


def length(told: Iterable[Interval]) -> float:
    """Return the time [s] that intervals cover together."""
    return sum(end - start for start, end in merged(told))


def shared(first: Iterable[Interval], second: Iterable[Interval]) -> float:
    """Return the time [s] that is in both."""
    return sum(
        max(min(end, stop) - max(start, begin), 0.0)
        for start, end in merged(first)
        for begin, stop in merged(second)
    )
