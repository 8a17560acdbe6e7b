"""RMSE of simulated signals on held-out data, before and after an improvement of the model."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from pneu_rig_ros.analysis.friction import ForceBalance
from pneu_rig_ros.analysis.metrics import UNITS, derived_signals, signal_noise, stroke_time
from pneu_rig_ros.analysis.motion import find_cycles
from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.residuals.balances import Comparison
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset
from pneu_rig_ros.diagnosis.residuals.replicates import bench_force, chamber_pressures
from pneu_rig_ros.diagnosis.residuals.shooting import MultipleShooting
from pneu_rig_ros.errors import RigError

NO_EVENTS = {'unit': '-', 'measured': None, 'before': None, 'after': None}


class SignalGap(NamedTuple):
    """Simulated minus measured values of a signal [unit], shape (n,), and its noise [unit]."""

    name: str
    unit: str
    noise: float
    gap: Floats


Compare = Callable[[Hypothesis, Comparison], list[SignalGap]]


def signal_tables(given: Hypothesis, improved: Hypothesis, held_out: Dataset) -> dict[str, Any]:
    """
    Return RMSE and events on held-out data, before and after, as in diagnosis.json.

    A whole rig is simulated from rest to rest, and freely. Otherwise the signals of the open
    balances are simulated along the measured motion, each run corrected for its nuisance
    parameters under each hypothesis.
    """
    runs = held_out.comparisons
    if not all(comparison.free for comparison in runs):
        events = dict.fromkeys(('cycles', 'dwell', 'stroke_time'), NO_EVENTS)
        signals = _rmse(
            runs, lambda h, c: imposed_gaps(h, held_out.aligned(h, c)), given, improved
        )
        return {'signals': signals, 'free_run': {}, **events}
    return {
        'signals': _rmse(runs, rig_gaps, given, improved),
        'free_run': _rmse(runs, lambda h, c: rig_gaps(h, c, free=True), given, improved),
        **_events(runs, given, improved),
    }


def rig_gaps(
    hypothesis: Hypothesis, comparison: Comparison, free: bool = False
) -> list[SignalGap]:
    """Return the gaps of the measured and the derived signals of a rig."""
    run, cylinder = comparison.run, hypothesis.model.cylinder
    load = hypothesis.conditions.get('load_mass', 1.0) * run.operation.load_mass
    mass = cylinder.moving_mass + load
    balance = ForceBalance(cylinder.cap_area, cylinder.rod_area, mass, run.atmospheric_pressure)
    x, p1, p2 = np.column_stack([run.position, run.pressures])[1:].T
    measured = derived_signals(x, p1, p2, run.interval, balance, run.name)
    try:
        x, p1, p2 = MultipleShooting(comparison).simulate(hypothesis, free).T
        simulated = derived_signals(x, p1, p2, run.interval, balance, run.name)
    except RigError:  # the simulation failed
        simulated = {name: np.full_like(values, np.nan) for name, values in measured.items()}
    pressure = max(run.noise.pressures)
    noise = signal_noise(run.noise.position, pressure, run.interval, balance)
    return [
        SignalGap(name, UNITS[name], noise[name], simulated[name] - values)
        for name, values in measured.items()
    ]


def imposed_gaps(hypothesis: Hypothesis, comparison: Comparison) -> list[SignalGap]:
    """Return the gaps of the pressures and the bench's force, along the measured motion."""
    run, rows = comparison.run, []
    chambers = [i for i in (0, 1) if f'gas_{i + 1}' in run.balances]
    simulated = chamber_pressures(hypothesis, comparison) if chambers else np.empty((0, 2))
    for i in chambers:
        gap = simulated[:, i] - run.pressures[1:, i]
        rows.append(SignalGap(f'pressure_{i + 1}', 'Pa', run.noise.pressures[i], gap))
    if 'force' in run.balances and run.force is not None:
        gap = bench_force(hypothesis, comparison) - 0.5 * (run.force[1:] + run.force[:-1])
        if run.force_offset > 0.0:  # the zero of the bench is unknown
            gap = gap - gap.mean()
        rows.append(SignalGap('force', 'N', run.noise.force, gap))
    return rows


def _rmse(
    runs: Sequence[Comparison], compare: Compare, given: Hypothesis, improved: Hypothesis
) -> dict[str, dict[str, Any]]:
    """Return signal -> unit, noise, RMSE before and after over all runs, None where it fails."""
    rows: dict[tuple[str, str], list[tuple[float, float, float]]] = {}
    for comparison in runs:
        pairs = zip(compare(given, comparison), compare(improved, comparison), strict=True)
        for before, after in pairs:
            squares = before.noise**2, float(np.mean(before.gap**2)), float(np.mean(after.gap**2))
            rows.setdefault((before.name, before.unit), []).append(squares)
    table = {}
    for (name, unit), each in rows.items():
        values = [np.sqrt(np.mean(column)) for column in zip(*each, strict=True)]
        table[name] = {'unit': unit, **_or_none(('noise', 'before', 'after'), values)}
    return table


def _events(
    runs: Sequence[Comparison], given: Hypothesis, improved: Hypothesis
) -> dict[str, dict[str, Any]]:
    """Return cycles, mean dwell and stroke time, measured, before and after."""
    names, hypotheses = ('measured', 'before', 'after'), (None, given, improved)
    table = np.array([[_events_of(run, each) for each in hypotheses] for run in runs])
    events = {'cycles': {'unit': '-', **_or_none(names, table[:, :, 0].sum(axis=0))}}
    for name, values in (('dwell', table[:, :, 1]), ('stroke_time', table[:, :, 2])):
        complete = values[np.isfinite(values).all(axis=1)]
        mean = complete.mean(axis=0) if complete.size else np.full(3, np.nan)
        events[name] = {'unit': 's', **_or_none(names, mean)}
    return events


def _or_none(names: Sequence[str], values: Iterable[float]) -> dict[str, float | None]:
    """Return name -> value, None where it is not finite."""
    pairs = zip(names, values, strict=True)
    return {name: float(value) if np.isfinite(value) else None for name, value in pairs}


def _events_of(
    comparison: Comparison, hypothesis: Hypothesis | None
) -> tuple[float, float, float]:
    """Return cycles, mean dwell and stroke time of a simulated run, or of the measured one."""
    run = comparison.run
    position = run.position[1:]
    if hypothesis is not None:
        try:
            position = MultipleShooting(comparison).simulate(hypothesis)[:, 0]
        except RigError:
            return np.nan, np.nan, np.nan
    cycles = find_cycles(position, run.interval)
    dwell = float(np.mean([cycle.dwell for cycle in cycles])) if cycles else np.nan
    duration = stroke_time(position, run.interval, run.stroke)
    return float(len(cycles)), dwell, np.nan if duration is None else duration
