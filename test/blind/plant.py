"""
The second plant: a hybrid system solved by SciPy's LSODA, with its events found on the way.

Nothing here comes from the package's model; only its configuration files are read, as plain YAML.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import LSODA

from . import constants as at
from . import forms
from .foreign_gas import RUN
from .gas import gas_rates
from .kept import kept
from .motion import drag, elements, levels, motion_rates, share_left, static_after
from .second_gas import targets

TOLERANCE = 1e-7
"""Local error of LSODA as a share of full scale [-]."""
LONGEST_STEP = 0.02
"""[s]"""
TOUCH_DEPTH = 1e-12
"""How far beyond a stop counts as contact [m]."""
TURN_RATE = 1e-8
"""Rate of the bristle [m/s] beyond which it counts as bent the other way."""
LEAST_HYSTERESIS = 1e-3
"""How far breakaway is above arrest at least, as a share of the velocity of arrest [-]."""
BREAKAWAY, ARREST, TOUCH, RELEASE = 'breakaway', 'arrest', 'touch', 'release'
TURN = 'turn'


class Motion(NamedTuple):
    """True signals at the sampling instants, shape (n,), SI, absolute pressures."""

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    pressure_1: np.ndarray
    pressure_2: np.ndarray
    sticking: np.ndarray
    states: np.ndarray = np.empty((0, at.STATES))
    """All of the state, where the plant made the motion, shape (n, STATES)."""


@kept
def rates(
    t: float,
    y: np.ndarray,
    dy: np.ndarray,
    memory: np.ndarray,
    c: np.ndarray,
    e: np.ndarray,
    stiffness: np.ndarray,
    limit: np.ndarray,
) -> float:
    """Write d(state)/dt; return the acceleration that no stop hinders."""
    dy[:] = 0.0
    gas_rates(y, dy, memory, c, e)
    return motion_rates(t, y, dy, memory, c, e, stiffness, limit)


def flatten(settings: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Return section.key -> value."""
    return {f'{s}.{k}': v for s, keys in settings.items() for k, v in keys.items()}


class Plant:
    """
    One rig at rest.

    :param settings: sections of a configuration as plain numbers, see ``settings``
    :param hidden: effect.parameter -> value of what the model does not know of
    """

    def __init__(
        self,
        settings: Mapping[str, Mapping[str, Any]],
        hidden: Mapping[str, float] | None = None,
        tolerance: float = TOLERANCE,
    ) -> None:
        numbers, law = flatten(settings), settings['friction']
        choices = (
            at.LAWS.index(law['model']),
            at.READINGS.index(law['static_friction_reading']),
            at.FILMS.index(law['film_reading']),
            at.FILM_RESTS.index(law['film_rest_reading']),
        )
        self.c = np.array([*(numbers[name] for name in at.CONSTANTS), *choices], dtype=float)
        secret = {**at.NONE_HIDDEN, **(hidden or {})}
        known = np.array([secret.pop(name, 0.0) for name in at.HIDDEN], dtype=float)
        given = {name: secret.pop(name) for name in tuple(secret) if forms.is_form(name)}
        self.e = np.concatenate([known, forms.numbers(given)])
        assert not secret, f'not in the equations: {", ".join(secret)}'
        self.stiffness = np.array(law['element_stiffness'], dtype=float)
        self.limit = np.array(law['element_limit'], dtype=float)
        self.tolerance = tolerance
        self._start(settings['operation'])

    def _start(self, operation: Mapping[str, float]) -> None:
        c, strange = self.c, self.e.size > at.FOREIGN
        y = np.zeros(forms.states(self.e))
        x, p1, p2 = (operation[f'initial_{s}'] for s in ('position', 'pressure_1', 'pressure_2'))
        rt = c[at.R] * c[at.T_S]
        y[at.X], y[at.P1], y[at.P2] = x, p1, p2
        y[at.M1] = p1 * (c[at.V10] + c[at.A1] * x) / rt
        y[at.M2] = p2 * (c[at.V20] + c[at.A2] * (c[at.STROKE] - x)) / rt
        y[at.SPOOL_1] = y[at.SPOOL_2] = 2.5
        if strange:
            y[[at.WALL_1, at.WALL_2]], y[at.SOURCE] = c[at.T_S], c[at.P_S]
            y[at.PIPE_1], y[at.PIPE_2] = p1, p2
        if len(y) == at.SECOND_STATES:
            y[at.SIDE_1], y[at.SIDE_2] = p1, p2
        self.y, self.t, self._way = y, 0.0, 0.0
        rest = operation['rest_time']
        held = static_after(rest, c[at.F_C], c[at.F_S], c, self.e)
        anchors = [0.0] * len(self.stiffness)
        self.memory = np.array([1.0, 0.0, -rest, 0.0, 0.0, held, 2.5, 2.5, *anchors])
        self.scale = self._full_scale()

    def _full_scale(self) -> np.ndarray:
        c = self.c
        scale = np.ones(len(self.y))
        scale[[at.P1, at.P2]] = c[at.P_S]
        scale[at.X] = c[at.STROKE]
        scale[at.Z] = max(c[at.F_S], c[at.F_C]) / self.stiffness.sum()
        scale[[at.M1, at.M2]] = c[at.P_S] * c[at.V10] / (c[at.R] * c[at.T_S])
        scale[[at.LINE_1, at.LINE_2]] = 1e-4
        scale[[at.STRETCH, at.SEAL]], scale[at.TANK] = 1e-3, c[at.P_S]
        if len(scale) > at.STATES:
            scale[at.CLOCK], scale[[at.WALL_1, at.WALL_2]] = 1e3, c[at.T_S]
            scale[[at.SPOOL_V1, at.SPOOL_V2]] = 1e2
            scale[[at.SOURCE, at.PIPE_1, at.PIPE_2]] = c[at.P_S]
            scale[[at.ELEMENT_1, at.ELEMENT_2, at.ELEMENT_3]] = c[at.F_S]
            scale[at.SWING] = 1e-2
        if len(scale) == at.SECOND_STATES:
            scale[[at.SIDE_1, at.SIDE_2]] = c[at.P_S]
        return scale

    def run(self, voltages: np.ndarray, interval: float) -> Motion:
        """Hold each row of voltages [V], shape (n, 2), for one interval [s]; samples 0 to n."""
        count = len(voltages)
        self.times = np.arange(count + 1) * interval
        self.states = np.empty((count + 1, len(self.y)))
        self.at_rest = np.ones(count + 1, dtype=bool)
        self.states[0], self._next = self.y, 1
        if self.e.size > at.FOREIGN:
            voltages = targets(voltages, interval, self.e)
        starts = np.flatnonzero(np.any(np.diff(voltages, axis=0, prepend=np.nan), axis=1))
        for first, last in zip(starts, [*starts[1:], count], strict=True):
            self._move_targets(voltages[first])
            self._integrate(float(self.times[last]))
        x, v, p1, p2 = self.states[:, : at.Z].T
        return Motion(self.times, x, v, p1, p2, self.at_rest, self.states)

    def _move_targets(self, voltages: np.ndarray) -> None:
        """Draw the spools along, as far as the play lets the voltages do so."""
        half = 0.5 * self.e[at.PLAY]
        for place, voltage in zip((at.TARGET_1, at.TARGET_2), voltages, strict=True):
            now = self.memory[place]
            self.memory[place] = min(max(now, voltage - half), voltage + half)

    def _integrate(self, end: float) -> None:
        """Go on to a time, from event to event."""
        while self.t < end:
            event = self._smooth_stretch(end)
            if event:
                self._apply(event)

    def _rate(self, t: float, y: np.ndarray) -> np.ndarray:
        dy = np.empty(len(y))
        self._pull = rates(t, y, dy, self.memory, self.c, self.e, self.stiffness, self.limit)
        return dy

    def _smooth_stretch(self, end: float) -> str:
        """Integrate to the next event, or to the end; return the event."""
        solver = LSODA(
            self._rate,
            self.t,
            self.y,
            end,
            first_step=min(1e-5, end - self.t),
            max_step=LONGEST_STEP,
            rtol=1e-9,
            atol=self.tolerance * self.scale,
        )
        side = 1.0 if self.y[at.V] > 0.0 else -1.0
        while solver.status == 'running':
            solver.step()
            assert solver.status != 'failed', 'LSODA gave up'
            event = self._event(solver.y, side)
            if event:
                t, y = self._locate(solver, side)
            else:
                t, y = solver.t, solver.y
            self._sample(solver, t)
            self.t, self.y = t, y
            drag(y[at.Z], self.memory, self.stiffness, self.limit)
            if event:
                return event
            self._way = self._way or self._turning(y)
        return ''

    def _event(self, now: np.ndarray, side: float) -> str:
        """Return the event that the step has passed, '' for none."""
        if self.memory[at.CONTACT] != 0.0:
            return RELEASE if self._free_pull(now) > 0.0 else ''
        depth = max(-now[at.X], now[at.X] - self._outer_stop(now))
        if depth > TOUCH_DEPTH and not self._leaves(now):
            return TOUCH
        if self.memory[at.STICKING] == 1.0:
            least = self.c[at.V_STOP] * (1.0 + LEAST_HYSTERESIS)
            if abs(now[at.V]) > max(self.c[at.V_START], least):
                return BREAKAWAY
        elif side * now[at.V] < self.c[at.V_STOP]:
            return ARREST
        return TURN if self._way * self._turning(now) < 0.0 else ''

    def _outer_stop(self, y: np.ndarray) -> float:
        """Position of the outer stop [m]; a foreign one creeps inward."""
        stroke = float(self.c[at.STROKE])
        if len(y) == at.STATES:
            return stroke
        return stroke - float(self.e[at.AT_STOP + 1] * y[at.CLOCK]) / RUN

    def _leaves(self, y: np.ndarray) -> bool:
        """Whether the piston moves away from a stop that creeps after it."""
        creeps = len(y) > at.STATES and self.e[at.AT_STOP + 1] > 0.0
        return bool(creeps and y[at.X] > 0.5 * self.c[at.STROKE] and y[at.V] <= 0.0)

    def _turning(self, y: np.ndarray) -> float:
        """Return which way the bristles are being bent; 0 without sliders, whose memory it is."""
        rate = self._rate(self.t, y)[at.Z] if self.limit.size else 0.0
        return float(np.sign(rate)) if abs(rate) > TURN_RATE else 0.0

    def _free_pull(self, y: np.ndarray) -> float:
        """Acceleration [m/s^2] away from the stop that is touched."""
        self._rate(self.t, y)
        return -float(self.memory[at.CONTACT]) * self._pull

    def _locate(self, solver: LSODA, side: float) -> tuple[float, np.ndarray]:
        """Return time and state just behind the event, by bisection."""
        dense = solver.dense_output()
        low, high = self.t, solver.t
        for _ in range(60):
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            if self._event(dense(middle), side):
                high = middle
            else:
                low = middle
        return high, dense(high)

    def _sample(self, solver: LSODA, until: float) -> None:
        """Keep the states at the sampling instants up to a time."""
        last = int(np.searchsorted(self.times, until, side='right'))
        if last > self._next:
            wanted = slice(self._next, last)
            self.states[wanted] = solver.dense_output()(self.times[wanted]).T
            self.at_rest[wanted] = self.memory[at.STICKING] == 1.0
            self._next = last

    def _apply(self, event: str) -> None:
        """Let jump what jumps."""
        memory = self.memory
        if event == BREAKAWAY:
            bristles = elements(self.y[at.Z], memory, self.stiffness, self.limit)
            coulomb, largest = levels(self.y, bristles, memory, self.c, self.e)
            dwell = self.t - memory[at.REST_START]
            memory[at.HELD] = static_after(dwell, coulomb, largest, self.c, self.e)
            memory[at.SHARE] = share_left(self.t, memory, self.c, self.e)
            memory[at.STICKING], memory[at.SLIDE_START] = 0.0, self.t
        elif event == TURN:
            self._way = -self._way
        elif event == RELEASE:
            memory[at.CONTACT] = 0.0
        elif event == TOUCH:
            outer = self.y[at.X] > 0.5 * self.c[at.STROKE]
            memory[at.CONTACT] = 1.0 if outer else -1.0
            self.y[at.X] = self._outer_stop(self.y) if outer else 0.0
            self.y[at.V] = 0.0
        if event == ARREST or (event == TOUCH and memory[at.STICKING] == 0.0):
            memory[at.SHARE] = share_left(self.t, memory, self.c, self.e)
            memory[at.STICKING], memory[at.REST_START] = 1.0, self.t
