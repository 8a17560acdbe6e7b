"""RMSE of simulated signals on held-out data, before and after an improvement of the model."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from pneu_rig_ros.analysis.friction import ForceBalance
from pneu_rig_ros.analysis.metrics import (
    SignalGap,
    compare_signals,
    derived_signals,
    signal_noise,
    stroke_time,
)
from pneu_rig_ros.analysis.motion import find_cycles
from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.measured.hypothesis import Hypothesis
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.balances import Comparison
from pneu_rig_ros.diagnosis.residuals.dataset import Dataset
from pneu_rig_ros.diagnosis.residuals.replicates import bench_force, chamber_pressures
from pneu_rig_ros.diagnosis.residuals.shooting import MultipleShooting
from pneu_rig_ros.errors import RigError

NO_EVENTS = {'unit': '-', 'measured': None, 'before': None, 'after': None}

Gaps = dict[str, SignalGap]


def signal_tables(given: Hypothesis, improved: Hypothesis, held_out: Dataset) -> dict[str, Any]:
    """
    Return RMSE and events on held-out data, before and after, as in diagnosis.json.

    A whole rig is simulated from rest to rest, and freely. Otherwise the signals of the open
    balances are simulated along the measured motion, each run corrected for its nuisance
    parameters under each hypothesis.
    """
    runs, pair = held_out.comparisons, (given, improved)
    if not all(comparison.free for comparison in runs):
        events = dict.fromkeys(('cycles', 'dwell', 'stroke_time'), NO_EVENTS)
        gaps = [[imposed_gaps(h, run.aligned(h)) for run in held_out.runs] for h in pair]
        return {'signals': _rmse(*gaps), 'free_run': {}, **events}
    restarted, free = (
        [[simulated(h, run, freely) for run in runs] for h in pair] for freely in (False, True)
    )

    def table(simulations: Sequence[Sequence[Floats]]) -> dict[str, dict[str, Any]]:
        rows = zip(pair, simulations, strict=True)
        gaps = [[rig_gaps(h, *each) for each in zip(runs, row, strict=True)] for h, row in rows]
        return _rmse(*gaps)

    return {'signals': table(restarted), 'free_run': table(free), **_events(runs, restarted)}


def simulated(hypothesis: Hypothesis, comparison: Comparison, free: bool) -> Floats:
    """Return x [m], p1, p2 [Pa] as read, shape (n - 1, 3); NaN where the simulation failed."""
    try:
        return MultipleShooting(comparison).simulate(hypothesis, free)
    except RigError:
        return np.full((comparison.run.size - 1, 3), np.nan)


def rig_gaps(hypothesis: Hypothesis, comparison: Comparison, states: Floats) -> Gaps:
    """
    Return the gaps of the measured and the derived signals of a rig.

    :param states: simulated x [m], p1, p2 [Pa], shape (n - 1, 3)
    """
    run, cylinder = comparison.run, hypothesis.model.cylinder
    load = hypothesis.conditions.get('load_mass', 1.0) * run.operation.load_mass
    mass = cylinder.moving_mass + load
    balance = ForceBalance(cylinder.cap_area, cylinder.rod_area, mass, run.atmospheric_pressure)
    readings = np.column_stack([run.position, run.pressures])[1:]
    measured, modelled = (
        derived_signals(x, p1, p2, run.interval, balance, run.name)
        for x, p1, p2 in (readings.T, states.T)
    )
    read = run.noise
    noise = signal_noise(read.position, max(read.pressures), run.interval, balance)
    return compare_signals(measured, modelled, noise)


def imposed_gaps(hypothesis: Hypothesis, comparison: Comparison) -> Gaps:
    """Return the gaps of the pressures and the bench's force, along the measured motion."""
    run = comparison.run
    names, noises = ('pressure_1', 'pressure_2', 'force'), (*run.noise.pressures, run.noise.force)
    modelled = along_the_motion(hypothesis, comparison)
    return compare_signals(open_signals(run), modelled, dict(zip(names, noises, strict=True)))


def open_signals(run: Run) -> dict[str, Floats]:
    """
    Return the measured signals of the open balances of a system that is no whole rig, [SI].

    Pressures are those at the ends of the intervals, forces those in their middles, shape
    (n - 1,).
    """
    signals = {f'pressure_{i + 1}': run.pressures[1:, i] for i in run.chambers}
    if 'force' in run.balances and run.force is not None:
        signals['force'] = 0.5 * (run.force[1:] + run.force[:-1])
    return signals


def along_the_motion(hypothesis: Hypothesis, comparison: Comparison) -> dict[str, Floats]:
    """
    Return the same signals as modelled along the measured motion.

    The force has the zero of the measured one where that is unknown.
    """
    run, signals = comparison.run, {}
    if run.chambers:
        pressures = chamber_pressures(hypothesis, comparison)
        signals = {f'pressure_{i + 1}': pressures[:, i] for i in run.chambers}
    if (measured := open_signals(run).get('force')) is not None:
        force = bench_force(hypothesis, comparison)
        offset = (force - measured).mean() if run.force_zero_sd > 0.0 else 0.0
        signals['force'] = force - offset
    return signals


def _rmse(before: Sequence[Gaps], after: Sequence[Gaps]) -> dict[str, dict[str, Any]]:
    """Return signal -> unit, noise, RMSE before and after over all runs, None where it fails."""
    rows: dict[tuple[str, str], list[tuple[float, float, float]]] = {}
    for gaps, improved in zip(before, after, strict=True):
        for name, gap in gaps.items():
            squares = (gap.noise or 0.0) ** 2, gap.rmse**2, improved[name].rmse ** 2
            rows.setdefault((name, gap.unit), []).append(squares)
    table = {}
    for (name, unit), each in rows.items():
        values = [np.sqrt(np.mean(column)) for column in zip(*each, strict=True)]
        table[name] = {'unit': unit, **_or_none(('noise', 'before', 'after'), values)}
    return table


def _events(
    runs: Sequence[Comparison], simulations: Sequence[Sequence[Floats]]
) -> dict[str, dict[str, Any]]:
    """
    Return cycles, mean dwell and stroke time, measured, before and after.

    :param simulations: of the runs, before and after
    """
    names = 'measured', 'before', 'after'
    table = np.array(
        [
            [_events_of(one.run, x) for x in (one.run.position[1:], before[:, 0], after[:, 0])]
            for one, before, after in zip(runs, *simulations, strict=True)
        ]
    )
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


def _events_of(run: Run, position: Floats) -> tuple[float, float, float]:
    """Return cycles, mean dwell and stroke time of positions in a run, NaN where one is not."""
    if not np.isfinite(position).all():
        return np.nan, np.nan, np.nan
    cycles = find_cycles(position, run.interval, noise=run.noise.position)
    dwell = float(np.mean([cycle.dwell for cycle in cycles])) if cycles else np.nan
    duration = stroke_time(position, run.interval, run.stroke)
    return float(len(cycles)), dwell, np.nan if duration is None else duration
