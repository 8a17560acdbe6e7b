"""
Wrong statements about the recordings: exchanged sensors, a wrong unit, a wrong cylinder.

None of these is a small change, so no fit finds them: each alternative is tried as a whole, before
any cause is searched. It has to reduce the residuals of all balances at once.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.inputs.prepare_runs import prepare_runs
from pneu_rig_ros.diagnosis.inputs.system import System, load_system
from pneu_rig_ros.diagnosis.measured.run import Run
from pneu_rig_ros.diagnosis.residuals.balances import Comparison
from pneu_rig_ros.diagnosis.residuals.dataset import rms
from pneu_rig_ros.diagnosis.residuals.noise import white_variances
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.recording import PRESSURES, Recording
from pneu_rig_ros.rig.yaml_file import shipped

MUCH_SMALLER = 0.3
"""
Ratio of the residuals to those as stated, geometric mean over the balances, at most [-]. It was
0.01 to 0.11 for the right statement in 16 trials with a wrong one, and 2.4 or more for any other
in 25 trials in which all was as stated and an effect was hidden.
"""
COMPARED = 0.9
"""Share of the windows that both must have [-]."""
UNITS = (('psi', 'bar', 1e5 / 6894.757), ('bar', 'MPa', 10.0), ('kPa', 'bar', 100.0))
"""
Unit that is stated, that may be true, and their ratio [-]. The other way round the pressures of a
rig are refused as out of range.
"""


@dataclass(frozen=True)
class Misstatement:
    """
    A statement that may be wrong, and the system and its recordings with its alternative.

    :param name: of the condition
    :param stated, true: the stated and the alternative value, for display
    :param system: the system with the alternative
    :param recordings: the recordings with the alternative
    :param runs: the same, prepared for that system
    :param excess: misfit of the held-out data as stated [-]
    """

    name: str
    stated: str
    true: str
    system: System
    recordings: tuple[Recording, ...]
    runs: tuple[Run, ...] = ()
    excess: float = 0.0


def alternatives(system: System, recordings: Sequence[Recording]) -> Iterator[Misstatement]:
    """Yield all alternatives to what is stated."""
    if all(name in recording for recording in recordings for name in PRESSURES):
        exchanged = tuple(
            recording.with_signals(
                pressure_1=recording['pressure_2'], pressure_2=recording['pressure_1']
            )
            for recording in recordings
        )
        yield Misstatement('exchanged_chambers', 'p1 and p2', 'p2 and p1', system, exchanged)
        atmosphere = system.hypothesis.model.gas.atmospheric_pressure
        for stated, true, factor in UNITS:
            scaled = tuple(_scaled(recording, factor, atmosphere) for recording in recordings)
            yield Misstatement('pressure_unit', stated, true, system, scaled)
    if system.rig is not None:
        for name in shipped('cylinder_*.yaml'):
            other = load_system(name)
            if other.hypothesis.model.cylinder != system.hypothesis.model.cylinder:
                yield Misstatement('cylinder', system.name, name, other, tuple(recordings))


def _scaled(recording: Recording, factor: float, atmosphere: float) -> Recording:
    """Return a recording whose gauge pressures are multiplied."""
    zero = recording.conditions.get('atmospheric_pressure', atmosphere)
    signals = {name: zero + factor * (recording[name] - zero) for name in PRESSURES}
    return recording.with_signals(**signals)


def find_misstatement(
    system: System, recordings: Sequence[Recording], runs: Sequence[Run], paths: Sequence[Path]
) -> Misstatement | None:
    """Return the best alternative with its runs, None if none is clearly better than as stated."""
    before = _standardised(system, runs)
    least = MUCH_SMALLER
    best: Misstatement | None = None
    for each in alternatives(system, recordings):
        try:
            then = tuple(prepare_runs(each.recordings, each.system, paths))
        except RigError:  # it cannot be so
            continue
        ratio = _ratio(before, _standardised(each.system, then))
        if ratio < least:
            least, best = ratio, replace(each, runs=then)
    return best


def _standardised(system: System, runs: Sequence[Run]) -> list[Floats]:
    """Return the residuals of each balance, of all runs, in standard deviations, (n,) each."""
    rows = []
    for comparison in map(Comparison, runs):
        given = system.hypothesis
        residuals, inertia = comparison.evaluate(given)
        variances = white_variances(given, comparison, inertia)
        with np.errstate(divide='ignore', invalid='ignore'):  # a closed balance has no noise
            rows.append([r / np.sqrt(v) for r, v in zip(residuals, variances, strict=False)])
    return [np.concatenate(column) for column in zip(*rows, strict=True)]


def _ratio(before: Sequence[Floats], after: Sequence[Floats]) -> float:
    """Return the geometric mean over the balances of the ratio of RMS residuals [-]."""
    logarithms = []
    for old, new in zip(before, after, strict=True):
        known = np.isfinite(old)
        both = known & np.isfinite(new)
        if not known.any():
            continue
        if both.sum() < COMPARED * known.sum():
            return np.inf
        logarithms.append(np.log(rms(new[both]) / rms(old[both])))
    return float(np.exp(np.mean(logarithms))) if logarithms else np.inf
