"""One recording as it really was, and the intervals in which what is hidden exceeds the noise."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from . import constants as at
from .contributions import Equations, Seen, force, gas, inertia, seen, volumes
from .imposed import dragged
from .plant import Plant
from .second_gas import targets
from .settings import Settings
from .windows import Interval, exceeds, force_window, gas_window, intervals

GASES = ('gas_1', 'gas_2')
Truth = dict[str, dict[str, list[Interval]]]
"""Balance -> recording -> intervals [s]."""


class Noise(NamedTuple):
    """Standard deviation of a reading, rounding included."""

    position: float
    pressure: float
    force: float = 0.0


class Run(NamedTuple):
    """
    One recording.

    :param interval: between samples [s]
    :param states: at the samples or ``every`` times as often, shape (n, STATES)
    :param sticking: whether the piston rests and its friction is not to be seen, shape (n,)
    :param voltages: of the valves at each state, shape (n, 2)
    :param true, model: equations of the truth and of the model that is given
    :param errors: of the sensors, effect.parameter -> value
    :param rest: time before the recording [s]
    :param force: that is measured, at the samples, where it is [N]
    """

    name: str
    interval: float
    states: np.ndarray
    sticking: np.ndarray
    voltages: np.ndarray
    true: Equations
    model: Equations
    errors: Mapping[str, float]
    noise: Noise
    rest: float = 0.0
    every: int = 1
    force: np.ndarray | None = None

    @property
    def signals(self) -> dict[str, np.ndarray]:
        """What sensors without noise show at the samples [SI]."""
        states, voltages = self.shown.states[:: self.every], self.voltages[:: self.every]
        signals = {
            'position': states[:, at.X],
            'pressure_1': states[:, at.P1],
            'pressure_2': states[:, at.P2],
            'voltage_1': voltages[:, 0],
            'voltage_2': voltages[:, 1],
        }
        return signals if self.force is None else {**signals, 'force': self.force}

    @property
    def shown(self) -> Seen:
        """The run as the sensors see it."""
        return seen(self.states, self.interval / self.every, self.errors)

    def contributions(self, balances: tuple[str, ...]) -> dict[str, np.ndarray]:
        """Return balance -> contribution of what is hidden, at the samples."""
        shown, found = self.shown, {}
        if set(balances) & set(GASES):
            drawn = self.voltages
            if self.true.e.size > at.FOREIGN:
                drawn = targets(drawn, self.interval / self.every, self.true.e)
            drawn = dragged(drawn, self.true.e[at.PLAY])
            flows = gas(self.states, shown, drawn, self.voltages, self.true, self.model)
            found = dict(zip(GASES, flows[:: self.every].T, strict=True))
        if 'force' in balances:
            fine = self.interval / self.every
            found['force'] = force(
                self.states, shown, self.sticking, self.rest, fine, self.true, self.model
            )[:: self.every]
        return {name: found[name] for name in balances}

    def noise_of(self, balance: str) -> np.ndarray | float:
        """Return the standard deviation of a window's residual that is noise of the sensors."""
        c, states = self.model.c, self.states[:: self.every]
        if balance == 'force':
            window = force_window(self.interval)
            areas = float(np.hypot(c[at.A1], c[at.A2]))
            return float(
                np.hypot(
                    window.noise(2) * inertia(c, self.model.e) * self.noise.position,
                    window.noise(0) * np.hypot(areas * self.noise.pressure, self.noise.force),
                )
            )
        chamber = GASES.index(balance)
        rt, area = c[at.R] * c[at.T_S], c[[at.A1, at.A2]][chamber]
        stored = volumes(states, c)[:, chamber] / (c[at.KAPPA] * rt) * self.noise.pressure
        swept = states[:, [at.P1, at.P2]][:, chamber] * area / rt * self.noise.position
        return gas_window(self.interval).noise(1) * np.hypot(stored, swept)

    def intervals(self, balances: tuple[str, ...]) -> dict[str, list[Interval]]:
        """Return balance -> when the contribution, averaged in a window, exceeds the noise."""
        found = {}
        for name, contribution in self.contributions(balances).items():
            window = (force_window if name == 'force' else gas_window)(self.interval)
            mask = exceeds(contribution, window, self.noise_of(name))
            found[name] = intervals(mask, self.interval)
        return found


def truth_of_runs(runs: list[Run], balances: tuple[str, ...]) -> Truth:
    """Return balance -> recording -> intervals."""
    truth: Truth = {balance: {} for balance in balances}
    for run in runs:
        for balance, found in run.intervals(balances).items():
            truth[balance][run.name] = found
    return truth


def equations(settings: Settings, hidden: Mapping[str, float]) -> Equations:
    """Return a rig's equations with what is hidden in them."""
    plant = Plant(settings, hidden)
    return Equations(plant.c, plant.e, plant.stiffness, plant.limit)
