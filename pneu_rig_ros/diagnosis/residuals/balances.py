"""
Residuals in weak form: the imbalance that a hypothesis leaves in each balance of a run.

Gas in a chamber, Eq. 6 with mass and heat as one source::

    residual = mean(phi d(p V^k)/dt) / (k R T_s V^(k-1)) - modelled source          [kg/s]

piston, Eq. 8 with the missing force along the outstroke::

    residual = M mean(phi d2x/dt2) - modelled force (- force of a bench)             [N]

at each breakaway the force by which the seal held more than the model lets it [N], and at an end
stop the reading of the position less the place of that stop [m].
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from pneu_rig_ros.arrays import Floats, Indices
from pneu_rig_ros.diagnosis.measured.hypothesis import CALIBRATED, Hypothesis
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.weak_form import TestFunctions, at_samples, middles
from pneu_rig_ros.model import along, chambers
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.effect import LEAST_TIME, READING_BALANCES
from pneu_rig_ros.model.shape import without_shape

BALANCES = ('gas_1', 'gas_2', 'force')
UNITS = {'gas_1': 'kg/s', 'gas_2': 'kg/s', 'force': 'N'}
STOP_UNIT = 'm'
"""Of what the balance of forces has at an end stop, which holds the piston at its place."""


class WindowForm(NamedTuple):
    """
    Form of the test functions of a balance.

    :param power: of the sine, so that the first or the second derivative vanishes at the ends
    :param length: [s], as long as the duration of a slip permits
    :param overlap: windows that overlap at any instant
    """

    power: int
    length: float
    overlap: int


GAS_WINDOWS = WindowForm(power=2, length=0.1, overlap=2)
FORCE_WINDOWS = WindowForm(power=4, length=0.07, overlap=3)
STOP_WINDOWS = WindowForm(power=2, length=0.5, overlap=1)
"""A contact of a few seconds has several, so that they make a cell, and few beside sliding."""

LEAST_SAMPLES = 20
"""A test function has at least so many intervals."""
LOAD_WINDOW = 0.012
"""Length of the mean of the load at the end of a rest [s]."""
LEAST_LOAD = 0.2
"""A seal that breaks away at a smaller share of its strength is not held by friction [-]."""
RESOLVED = 5
"""Parts of the time in which a state changes, at least: 0.02 of the noise of the gas is left."""
FINEST = 0.4 * LEAST_TIME
"""Parts are not shorter [s]."""
SLOW_SAMPLING = 5e-3
"""Above this interval of samples effects of milliseconds neither show nor are integrated [s]."""


class Residuals(NamedTuple):
    """Of chamber 1 and 2 [kg/s], the sliding piston [N], its breakaways [N] and end stops [m]."""

    gas_1: Floats
    gas_2: Floats
    force: Floats
    breakaway: Floats
    stop: Floats


def changes(before: Residuals, after: Residuals) -> Residuals:
    """Return the change of each residual as a column, 0 where it is not finite, (m, 1) each."""
    pairs = zip(before, after, strict=True)
    return Residuals(*(np.nan_to_num(b - a)[:, np.newaxis] for a, b in pairs))


def side_by_side(*columns: Residuals) -> Residuals:
    """Return columns of shape (m, k), one beside the other."""
    return Residuals(*(np.hstack(each) for each in zip(*columns, strict=True)))


@dataclass(frozen=True)
class Comparison:
    """
    A run with the windows over which it is compared with hypotheses.

    :param run: whose motion counts
    :param readings: simulated readings without errors of the sensors, in place of the run's
    """

    run: Run
    readings: Run | None = None

    @cached_property
    def gas(self) -> TestFunctions:
        """Windows of the gas balances."""
        return self._windows(GAS_WINDOWS)

    @cached_property
    def motion(self) -> TestFunctions:
        """Windows of the balance of forces."""
        return self._windows(FORCE_WINDOWS)

    @cached_property
    def stops(self) -> TestFunctions:
        """Windows of the readings at an end stop."""
        return self._windows(STOP_WINDOWS)

    def _windows(self, form: WindowForm) -> TestFunctions:
        size = max(round(form.length / self.run.interval), LEAST_SAMPLES)
        hop = max(round(size / form.overlap), 1)
        return TestFunctions.of(form.power, size, hop, self.run.size - 1, self.run.interval)

    @cached_property
    def breakaways(self) -> Indices:
        """The last interval of each rest that ends with a breakaway, shape (breakaways,)."""
        return np.array([rest.end - 2 for rest in self.run.breakaways], dtype=np.intp)

    def zeros(self, count: int) -> Residuals:
        """Return so many columns of zeros, shape (m, count) each."""
        gas, motion, stops = (each.starts.size for each in (self.gas, self.motion, self.stops))
        sizes = gas, gas, motion, self.breakaways.size, stops
        return Residuals(*(np.zeros((size, count)) for size in sizes))

    @property
    def free(self) -> bool:
        """Whether the model moves the piston: all balances are open, and there is no bench."""
        return len(self.run.balances) == len(BALANCES) and self.run.force is None

    @property
    def window_velocity(self) -> Floats:
        """Mean velocity in each window of the motion [m/s], shape (m,)."""
        return self.motion.averages(self.run.velocity)

    def residuals(self, hypothesis: Hypothesis) -> Residuals:
        """Return the residuals of all windows, NaN where a balance cannot be evaluated."""
        return self.evaluate(hypothesis)[0]

    def evaluate(self, hypothesis: Hypothesis) -> tuple[Residuals, Floats]:
        """Return the residuals, and the accelerated mass in each window of the motion [kg]."""
        run, velocity = self.corrected(hypothesis)
        rates, _ = self._along(hypothesis, run, velocity)
        inertia = self.motion.averages(rates[:, along.INERTIA])
        gas_1, gas_2 = (self._gas(hypothesis, run, rates, chamber) for chamber in (1, 2))
        force = self._force(run, rates, inertia)
        breakaway = self._breakaway(hypothesis, run, rates)
        return Residuals(gas_1, gas_2, force, breakaway, self._stop(hypothesis, run)), inertia

    def rates(self, hypothesis: Hypothesis) -> Floats:
        """Return the modelled rates in each interval, see ``model.along``, shape (n - 1, 5)."""
        return self._along(hypothesis, *self.corrected(hypothesis))[0]

    def corrected(self, hypothesis: Hypothesis) -> tuple[Run, Floats]:
        """
        Return the run without the errors that the sensors have, and its velocity [m/s], (n - 1,).

        The velocity is that of the readings, corrected: that of a corrected run would change the
        rests.
        """
        if self.readings is not None:
            return self.readings, self.run.velocity
        run, velocity = self.run, self.run.velocity
        gains, offsets = hypothesis.gains, hypothesis.offsets
        if gains != CALIBRATED or any(offsets):
            run, velocity = run.with_gains(gains, offsets), velocity / gains[0]
        if any(library.load(name).balance in READING_BALANCES for name in hypothesis.effects):
            bias = np.nan_to_num(self._along(hypothesis, run, velocity)[1])
            errors = at_samples(bias)
            run = run.with_readings(run.position - errors[:, 0], run.pressures - errors[:, 1:])
            drift = np.gradient(bias[:, 0], run.interval)
            velocity = np.where(velocity != 0.0, velocity - drift, 0.0)
        return run, velocity

    def _along(self, hypothesis: Hypothesis, run: Run, velocity: Floats) -> tuple[Floats, Floats]:
        """Return modelled rates and errors of the sensors along a run, shape (n - 1, k) each."""
        parts = substeps(hypothesis, run)
        rates, bias = hypothesis.plant_of(run).along(
            interpolated(run.smooth, parts),
            np.repeat(velocity, parts),
            np.repeat(self.run.contacts, parts),
            np.repeat(hypothesis.voltages(run), parts, axis=0),
            run.interval / parts,
        )
        if parts == 1:
            return rates, bias
        with np.errstate(over='ignore'):  # a trial value may let a state grow without bounds
            # five times as fast as mean(), which is slow along a short axis
            rates, bias = (
                np.einsum('ijk->ik', rows.reshape(-1, parts, rows.shape[1])) / parts
                for rows in (rates, bias)
            )
        return rates, bias

    def _gas(self, hypothesis: Hypothesis, run: Run, rates: Floats, chamber: int) -> Floats:
        gas = hypothesis.model.gas
        k = gas.heat_capacity_ratio
        enthalpy = k * gas.gas_constant * gas.supply_temperature
        volume = chamber_volume(hypothesis, run.position, chamber)
        middle = middles(volume)
        with np.errstate(invalid='ignore'):  # a trial error of x may put it beyond the ends
            volume_k, middle_k = volume**k, middle ** (k - 1.0)
            typical = self.gas.averages(middle) ** (k - 1.0)
            stored = self.gas.rates(run.pressures[:, chamber - 1] * volume_k)
            source = self.gas.means(rates[:, along.SOURCE_1 + chamber - 1] * middle_k)
            return (stored / enthalpy - source) / typical

    def _force(self, run: Run, rates: Floats, inertia: Floats) -> Floats:
        missing = inertia * self.motion.accelerations(run.position)
        with np.errstate(invalid='ignore'):  # a trial value may let a force grow without bounds
            missing = missing - self.motion.means(rates[:, along.FORCE])
        if run.force is not None:
            missing -= self.motion.means(middles(run.force))
        return missing

    def _breakaway(self, hypothesis: Hypothesis, run: Run, rates: Floats) -> Floats:
        """Return the driving force beyond that at which the model breaks away, by its load."""
        drive = driving_force(hypothesis, run)
        size = max(round(LOAD_WINDOW / run.interval), 1)
        beyond = np.full(self.breakaways.size, np.nan)
        for index, end in enumerate(self.breakaways):
            window = slice(max(end + 1 - size, 0), end + 1)
            loads = rates[window, along.LOADING]
            loads = loads[np.isfinite(loads)]
            if loads.size:
                load = max(loads.mean(), LEAST_LOAD)
                beyond[index] = drive[window].mean() * (1.0 - 1.0 / load)
        return beyond

    def _stop(self, hypothesis: Hypothesis, run: Run) -> Floats:
        """Return the mean reading less the place of the end stop, NaN where none holds."""
        off, stroke = np.full(self.stops.starts.size, np.nan), hypothesis.model.cylinder.stroke
        for contact, place in ((along.AT_INNER_STOP, 0.0), (along.AT_OUTER_STOP, stroke)):
            held = self.stops.inside(self.run.contacts == contact)
            off[held] = self.stops.averages(run.position[1:] - place)[held]
        return off


def chamber_volume(hypothesis: Hypothesis, position: Floats, chamber: int) -> Floats:
    """Return the gas volume at positions [m], shape (n,) [m^3]."""
    volumes: Any = chambers.volumes
    volume: Floats = volumes(position, hypothesis.model.cylinder)[chamber - 1]
    return volume


def driving_force(hypothesis: Hypothesis, run: Run) -> Floats:
    """Return the force of the gas on the piston in each interval [N], shape (n - 1,)."""
    cylinder = hypothesis.model.cylinder
    _, p1, p2 = middles(run.smooth).T
    a1, a2 = cylinder.cap_area, cylinder.rod_area
    force: Floats = p1 * a1 - p2 * a2 - run.atmospheric_pressure * (a1 - a2)
    return force


def substeps(hypothesis: Hypothesis, run: Run) -> int:
    """Return the parts of an interval that resolve the states of the acting effects in a run."""
    interval, parts = run.interval, 1
    model = hypothesis.model._replace(operation=run.operation)
    for name, own in hypothesis.effects.items():
        effect, parameters = library.load(name), without_shape(own)
        # an empirical effect has a state for each of its terms: only those in use act
        active = not effect.describes or any(getattr(parameters, s) != 0.0 for s in effect.states)
        if effect.states and active and interval <= SLOW_SAMPLING:
            time = effect.shortest_time(parameters, model)
            parts = max(parts, math.ceil(RESOLVED * interval / time))
    return min(parts, math.ceil(interval / FINEST))


def interpolated(samples: Floats, parts: int) -> Floats:
    """Return samples with linear interpolation between them, shape (parts (n - 1) + 1, k)."""
    if parts == 1:
        return samples
    steps = np.diff(samples, axis=0)[:, np.newaxis] * (np.arange(parts) / parts)[:, np.newaxis]
    between = (samples[:-1, np.newaxis] + steps).reshape(-1, samples.shape[1])
    return np.vstack([between, samples[-1:]])
