"""
What the measured run lacks in each balance under a hypothesis: residuals of the weak form.

Of the gas in a chamber, Eq. 6 as one source of mass and heat together::

    residual = mean(phi d(p V^k)/dt) / (k R T_s V^(k-1)) - modelled source          [kg/s]

of the piston, Eq. 8 as the force that is missing along the outstroke::

    residual = M mean(phi d2x/dt2) - modelled force (- force of a bench)             [N]

and at every breakaway by how much more the seal held than the model lets it [N].
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.diagnosis.hypothesis import CALIBRATED, Hypothesis
from pneu_rig_ros.diagnosis.run import Run
from pneu_rig_ros.diagnosis.weak_form import Floats, TestFunctions
from pneu_rig_ros.model import along, chambers
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.compiled import plain
from pneu_rig_ros.model.effect import LEAST_TIME, READING_BALANCES

CHAMBERS = (1, 2)
GAS_WINDOW, FORCE_WINDOW = 0.1, 0.07
"""Length of the test functions [s]: as long as what happens in a slip lets them be."""
LEAST_SAMPLES = 20
"""A test function has at least so many intervals."""
GAS_POWER, FORCE_POWER = 2, 4
"""Of the sine: the first and the second derivative of the test functions vanish at their ends."""
GAS_OVERLAP, FORCE_OVERLAP = 2, 3
"""Windows that overlap any one instant."""
LAST = 0.012
"""Length of the mean of the load at the end of a rest [s]."""


class Residuals(NamedTuple):
    """Of chamber 1 and 2 [kg/s], the sliding piston [N] and its breakaways [N]."""

    gas_1: Floats
    gas_2: Floats
    force: Floats
    breakaway: Floats


UNITS = Residuals('kg/s', 'kg/s', 'N', 'N')  # type: ignore[arg-type]


@dataclass(frozen=True)
class Comparison:
    """
    One measured run, and the windows over which it is compared.

    :param run: the run
    """

    run: Run

    @cached_property
    def gas(self) -> TestFunctions:
        """Windows of the gas balances."""
        return self._windows(GAS_POWER, GAS_WINDOW, GAS_OVERLAP)

    @cached_property
    def motion(self) -> TestFunctions:
        """Windows of the balance of forces."""
        return self._windows(FORCE_POWER, FORCE_WINDOW, FORCE_OVERLAP)

    def _windows(self, power: int, length: float, overlap: int) -> TestFunctions:
        size = max(round(length / self.run.interval), LEAST_SAMPLES)
        hop = max(round(size / overlap), 1)
        return TestFunctions.of(power, size, hop, self.run.size - 1, self.run.interval)

    @property
    def free(self) -> bool:
        """Whether the model moves the piston: all balances are open, and there is no bench."""
        return len(self.run.balances) == len(CHAMBERS) + 1 and self.run.force is None

    def corrected(self, hypothesis: Hypothesis) -> Run:
        """Return the run as sensors without the errors of a hypothesis would have read it."""
        run = self.run
        if hypothesis.gains != CALIBRATED:
            x, p1, p2 = hypothesis.gains
            zero = run.atmospheric_pressure
            pressures = zero + (run.pressures - zero) / np.array([p1, p2])
            run = run.read_again(run.position / x, pressures)
        if any(library.load(name).balance in READING_BALANCES for name in hypothesis.effects):
            bias = np.nan_to_num(self._march(hypothesis, run)[1])
            at_samples = np.vstack([bias[:1], 0.5 * (bias[1:] + bias[:-1]), bias[-1:]])
            run = run.read_again(run.position - at_samples[:, 0],
                                 run.pressures - at_samples[:, 1:])  # fmt: skip
        return run

    def _march(self, hypothesis: Hypothesis, run: Run) -> tuple[Floats, Floats]:
        plant = hypothesis.plant_of(run)
        slow, parts = self.run, substeps(hypothesis, run.interval)  # the speed of the readings
        rates, bias = plant.along(
            refined(run.smooth, parts), np.repeat(slow.velocity / hypothesis.gains[0], parts),
            np.repeat(slow.contacts, parts), np.repeat(run.voltages, parts, axis=0),
            run.interval / parts,
        )  # fmt: skip
        if parts == 1:
            return rates, bias
        mean_rates, mean_bias = (
            every.reshape(-1, parts, every.shape[1]).mean(axis=1) for every in (rates, bias)
        )
        return mean_rates, mean_bias

    def residuals(self, hypothesis: Hypothesis) -> Residuals:
        """Return the residuals of all windows; NaN where a balance says nothing."""
        run = self.corrected(hypothesis)
        rates, _ = self._march(hypothesis, run)
        gas_1, gas_2 = (self._gas(hypothesis, run, rates, chamber) for chamber in CHAMBERS)
        breakaway = self._breakaway(hypothesis, run, rates)
        return Residuals(gas_1, gas_2, self._force(run, rates), breakaway)

    def _gas(self, hypothesis: Hypothesis, run: Run, rates: Floats, chamber: int) -> Floats:
        gas, cylinder = hypothesis.model.gas, hypothesis.model.cylinder
        k = gas.heat_capacity_ratio
        enthalpy = k * gas.gas_constant * gas.supply_temperature
        position: Any = run.position
        volume = plain(chambers.volumes)(position, cylinder)[chamber - 1] + 0.0 * position
        middle = 0.5 * (volume[1:] + volume[:-1])
        with np.errstate(invalid='ignore'):  # an error of x that is tried may be beyond the ends
            volume_k, middle_k = volume**k, middle ** (k - 1.0)
            typical = self.gas.plain_means(middle) ** (k - 1.0)
        stored = self.gas.rates(run.pressures[:, chamber - 1] * volume_k)
        source = self.gas.means(rates[:, along.SOURCE_1 + chamber - 1] * middle_k)
        return (stored / enthalpy - source) / typical

    def rates(self, hypothesis: Hypothesis) -> Floats:
        """Return the modelled rates in each interval, see ``model.along``, shape (n - 1, 5)."""
        return self._march(hypothesis, self.corrected(hypothesis))[0]

    def inertia(self, hypothesis: Hypothesis) -> Floats:
        """Return what is accelerated in each window of the motion [kg], NaN at rest."""
        rates, _ = self._march(hypothesis, self.run)
        return self.motion.plain_means(rates[:, along.INERTIA])

    def _force(self, run: Run, rates: Floats) -> Floats:
        acceleration = self.motion.accelerations(run.position)
        inertia = self.motion.plain_means(rates[:, along.INERTIA])
        missing = inertia * acceleration - self.motion.means(rates[:, along.FORCE])
        if run.force is not None:
            missing -= self.motion.means(0.5 * (run.force[1:] + run.force[:-1]))
        return missing

    @cached_property
    def ends(self) -> NDArray[np.intp]:
        """The last interval of each rest that a slide follows, shape (breakaways,)."""
        rests = self.run.contacts == along.RESTS
        moves = self.run.contacts == along.MOVES
        return np.flatnonzero(rests[:-1] & moves[1:])

    def _breakaway(self, hypothesis: Hypothesis, run: Run, rates: Floats) -> Floats:
        drive = driving_force(hypothesis, run)
        last = max(round(LAST / run.interval), 1)
        held = []
        for end in self.ends:
            here = slice(max(end + 1 - last, 0), end + 1)
            load = float(np.nanmean(rates[here, along.LOADING]))
            force = float(drive[here].mean())
            held.append(force * (1.0 - 1.0 / max(load, LEAST_LOAD)))
        return np.array(held)


LEAST_LOAD = 0.2
"""A seal that breaks away at less is not held by friction [-]."""


def driving_force(hypothesis: Hypothesis, run: Run) -> Floats:
    """Return the force of the gas on the piston in each interval [N], shape (n - 1,)."""
    cylinder = hypothesis.model.cylinder
    p1, p2 = 0.5 * (run.smooth[1:, 1:] + run.smooth[:-1, 1:]).T
    a1, a2 = cylinder.cap_area, cylinder.rod_area
    force: Floats = p1 * a1 - p2 * a2 - run.atmospheric_pressure * (a1 - a2)
    return force


def substeps(hypothesis: Hypothesis, interval: float) -> int:
    """Return into how many parts an interval [s] is divided, so that effects' states keep up."""
    acting = any(_remembers(name, own) for name, own in hypothesis.effects.items())
    if not acting or interval > SLOW:
        return 1
    return min(int(np.ceil(interval / (0.4 * LEAST_TIME))), MOST_SUBSTEPS)


def _remembers(name: str, parameters: Any) -> bool:
    """Return whether an effect has states that act: of a description, those of its own terms."""
    effect = library.load(name)
    if not effect.describes:
        return bool(effect.states)
    return any(getattr(parameters, state) != 0.0 for state in effect.states)


MOST_SUBSTEPS = 16
SLOW = 5e-3
"""Interval of samples from which on no effect of milliseconds is looked for [s]."""


def refined(samples: Floats, parts: int) -> Floats:
    """Return samples with others between them on straight lines, shape (parts (n - 1) + 1, k)."""
    if parts == 1:
        return samples
    steps = np.diff(samples, axis=0)[:, np.newaxis] * (np.arange(parts) / parts)[:, np.newaxis]
    between = (samples[:-1, np.newaxis] + steps).reshape(-1, samples.shape[1])
    return np.vstack([between, samples[-1:]])
