"""How far an explanation brings simulated and measured signals together on runs left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneu_rig_ros.analysis.comparison import UNITS, derived_signals, signal_noise, stroke_time
from pneu_rig_ros.analysis.friction import ForceBalance
from pneu_rig_ros.analysis.stick_slip import find_cycles
from pneu_rig_ros.diagnosis.balances import Comparison
from pneu_rig_ros.diagnosis.dataset import Dataset
from pneu_rig_ros.diagnosis.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.shooting import MultipleShooting, bench_force, chamber_pressures
from pneu_rig_ros.errors import RigError

Floats = NDArray[np.float64]
Signals = Mapping[str, Floats]
NOTHING = {'unit': '-', 'measured': None, 'before': None, 'after': None}


def signal_tables(given: Hypothesis, improved: Hypothesis, held: Dataset) -> dict[str, Any]:
    """
    Return RMSE and events on the runs left out, measured, before and after, as plain data.

    Of a whole rig they are those of a simulation from rest to rest, and of a free run; of anything
    less those of what is open, along the measured motion, with the clock's offset and the
    temperatures at the start that a run has under each hypothesis.
    """
    runs = held.comparisons
    if all(one.free for one in runs):
        return {
            'signals': _table(runs, lambda h, one: of_rig(h, one), given, improved),
            'free_run': _table(runs, lambda h, one: of_rig(h, one, free=True), given, improved),
            **events(runs, given, improved),
        }
    signals = _table(runs, lambda h, one: of_part(h, held.aligned(h, one)), given, improved)
    return {'signals': signals, 'free_run': {}, 'cycles': NOTHING, 'dwell': NOTHING,
            'stroke_time': NOTHING}  # fmt: skip


def balance_of(hypothesis: Hypothesis, one: Comparison) -> ForceBalance:
    """Return the constants of Eq. 2 under the conditions of a run."""
    cylinder = hypothesis.model.cylinder
    load = hypothesis.conditions.get('load_mass', 1.0) * one.run.operation.load_mass
    mass = cylinder.moving_mass + load
    return ForceBalance(cylinder.cap_area, cylinder.rod_area, mass, one.run.atmospheric_pressure)


def signals_of(hypothesis: Hypothesis, one: Comparison, readings: Floats) -> Signals:
    """Return the signals of readings x, p1, p2, shape (n, 3), and those derived of them."""
    x, p1, p2 = readings.T
    return derived_signals(x, p1, p2, one.run.interval, balance_of(hypothesis, one), one.run.name)


def of_rig(
    hypothesis: Hypothesis, one: Comparison, free: bool = False
) -> list[tuple[str, str, float, Floats]]:
    """Return name, unit, noise and simulated less measured of each signal of a rig."""
    run = one.run
    measured = signals_of(hypothesis, one, np.column_stack([run.position, run.pressures])[1:])
    try:
        simulated = signals_of(hypothesis, one, MultipleShooting(one).simulate(hypothesis, free))
    except RigError:  # it broke down
        simulated = {name: np.full_like(values, np.nan) for name, values in measured.items()}
    pressure = max(run.noise.pressure_1, run.noise.pressure_2)
    noise = signal_noise(run.noise.position, pressure, run.interval, balance_of(hypothesis, one))
    return [(name, UNITS[name], noise[name], simulated[name] - values)
            for name, values in measured.items()]  # fmt: skip


def of_part(hypothesis: Hypothesis, one: Comparison) -> list[tuple[str, str, float, Floats]]:
    """Return the same of the pressures and the bench's force, along the measured motion."""
    run, rows = one.run, []
    noises = run.noise.pressure_1, run.noise.pressure_2
    if any(name.startswith('gas') for name in run.balances):
        simulated = chamber_pressures(hypothesis, one)
        for i in (0, 1):
            if f'gas_{i + 1}' in run.balances:
                gap = simulated[:, i] - run.pressures[1:, i]
                rows.append((f'pressure_{i + 1}', 'Pa', noises[i], gap))
    if 'force' in run.balances and run.force is not None:
        gap = bench_force(hypothesis, one) - 0.5 * (run.force[1:] + run.force[:-1])
        if run.force_offset > 0.0:
            gap = gap - gap.mean()
        rows.append(('force', 'N', run.noise.force, gap))
    return rows


def _table(
    runs: Sequence[Comparison], compare: Any, given: Hypothesis, improved: Hypothesis
) -> dict[str, dict[str, Any]]:
    """Return signal -> unit, noise, RMSE before and after over all runs."""
    rows: dict[str, list[tuple[str, float, float, float]]] = {}
    for one in runs:
        pairs = zip(compare(given, one), compare(improved, one), strict=True)
        for (name, unit, noise, old), (_, _, _, new) in pairs:
            squares = (noise**2, float(np.mean(old**2)), float(np.mean(new**2)))
            rows.setdefault(name, []).append((unit, *squares))
    return {name: _row(table) for name, table in rows.items()}


def _row(table: Sequence[tuple[str, float, float, float]]) -> dict[str, Any]:
    noise, before, after = (float(np.sqrt(np.mean([r[i] for r in table]))) for i in (1, 2, 3))
    known = {'noise': noise, 'before': before, 'after': after}
    return {'unit': table[0][0], **{n: v if np.isfinite(v) else None for n, v in known.items()}}


def events(runs: Sequence[Comparison], given: Hypothesis, improved: Hypothesis) -> dict[str, Any]:
    """Return cycles, dwells and stroke time, measured, before and after, as plain data."""
    table = np.array([[_events(given, one, hypothesis) for hypothesis in (None, given, improved)]
                      for one in runs])  # fmt: skip
    cycles = table[:, :, 0].sum(axis=0)
    return {
        'cycles': _told('-', cycles),
        'dwell': _told('s', _mean_known(table[:, :, 1])),
        'stroke_time': _told('s', _mean_known(table[:, :, 2])),
    }


def _events(
    given: Hypothesis, one: Comparison, hypothesis: Hypothesis | None
) -> tuple[float, float, float]:
    """Return cycles, mean dwell and stroke time of a run; of the measured one without a model."""
    run = one.run
    if hypothesis is None:
        position = run.position[1:]
    else:
        try:
            position = MultipleShooting(one).simulate(hypothesis)[:, 0]
        except RigError:
            return np.nan, np.nan, np.nan
    cycles = find_cycles(position, run.interval)
    reached = stroke_time(position, run.interval, run.stroke)
    dwell = float(np.mean([c.dwell for c in cycles])) if cycles else np.nan
    return float(len(cycles)), dwell, np.nan if reached is None else reached


def _mean_known(table: Floats) -> Floats:
    """Return the means over the runs in which all three are known, shape (3,)."""
    known = np.isfinite(table).all(axis=1)
    return table[known].mean(axis=0) if known.any() else np.full(3, np.nan)


def _told(unit: str, triple: Floats) -> dict[str, Any]:
    measured, before, after = (float(v) if np.isfinite(v) else None for v in triple)
    return {'unit': unit, 'measured': measured, 'before': before, 'after': after}
