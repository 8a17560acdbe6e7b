"""The workflow for a part: where it disagrees, what is missing, and the answer as plain data."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pneu_rig_ros.executor import Executor, Here
from pneu_rig_ros.gap.bags import parted
from pneu_rig_ros.gap.candidates import Candidate
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.parts.candidates import effects, parameters
from pneu_rig_ros.gap.parts.evidence import PartEvidence
from pneu_rig_ros.gap.parts.part import Part, load_part
from pneu_rig_ros.gap.parts.prediction import Channel
from pneu_rig_ros.gap.parts.recording import REGIMES, Recording, read_recording
from pneu_rig_ros.gap.parts.selection import CONSISTENT, PartScore, PartSearch
from pneu_rig_ros.model import effects as library

Tell = Callable[[str, float], None]
SIGNIFICANT = 3.0
"""RMS of a gap in noises from which on a regime is told [-]."""
ALIKE = 0.05
"""Explanations whose gaps left out differ by less cannot be told apart [-]."""
MOST_CANDIDATES = 20
"""Candidates that are told."""
MOST_STEPS = 40.0
"""Steps that a diagnosis takes at most, for its progress [-]."""


@dataclass(frozen=True)
class PartDiagnosis:
    """
    What a diagnosis of a part found.

    :param model: the file given
    :param search: with its recordings
    :param best: the explanation, empty where there is none
    """

    model: str
    search: PartSearch
    best: PartScore
    seconds: float

    @property
    def part(self) -> Part:
        """The given part."""
        return self.search.part

    @property
    def improved(self) -> Part:
        """The part with the explanation."""
        return self.part.with_hypothesis(self.best.explanation.apply(self.part.hypothesis))

    @property
    def verdict(self) -> str:
        """One of consistent, parameter, effect, unknown."""
        if self.best.effects:
            return 'effect'
        if self.best.explanation.parts:
            return 'parameter'
        return 'consistent' if self.search.given.worst < CONSISTENT else 'unknown'


def diagnose_part(
    tables: Sequence[Path], model: Path, mapping: Path | None = None,
    verify: Sequence[Path] = (), kind: str | None = None, without: Sequence[str] = (),
    executor: Executor | None = None, tell: Tell = lambda text, share: None,
) -> PartDiagnosis:  # fmt: skip
    """
    Diagnose a part with measured tables or bags.

    :param tables: measured runs
    :param model: file of the part
    :param mapping: which column is what, and its unit
    :param verify: runs that are left out of the fits; every third one where none is named
    :param kind: of the part, where the file does not say it
    :param without: effects that the library shall lack
    :param executor: where candidates are screened and fitted; this process if it is not said
    :param tell: told what is done now, and the share of the work done [-]
    :raises RigError: when a file cannot be used
    """
    part = load_part(model, kind)
    fit, held = parted(tables, verify)
    outside = part.hypothesis.model.gas.atmospheric_pressure
    tell('reading', 0.0)
    groups = [
        [read_recording(path, mapping, part.kind, outside) for path in group]
        for group in (fit, held)
    ]
    return find_out(part, groups[0], groups[1], without, executor, tell, str(model))


def find_out(
    part: Part, fit: Sequence[Recording], held: Sequence[Recording], without: Sequence[str] = (),
    executor: Executor | None = None, tell: Tell = lambda text, share: None, model: str = '',
) -> PartDiagnosis:  # fmt: skip
    """Diagnose a part with recordings that have been read; see :func:`diagnose_part`."""
    begin, steps = time.perf_counter(), [0.0]

    def progress(text: str) -> None:
        steps[0] += 1.0
        tell(text, min(steps[0] / MOST_STEPS, 0.95))

    seen = [i for i in (1, 2) if all(f'pressure_{i}' in one for one in (*fit, *held))]
    search = PartSearch(
        PartEvidence(part, fit), PartEvidence(part, held), parameters(part),
        effects(part, without, seen), progress, executor or Here(),
    )  # fmt: skip
    best = search.run()
    return PartDiagnosis(model or part.name, search, best, time.perf_counter() - begin)


def answer(diagnosis: PartDiagnosis) -> dict[str, Any]:
    """Return diagnosis.json as plain data, schema in docs/."""
    search = diagnosis.search
    return {
        'version': 1,
        'part': diagnosis.part.kind,
        'model': diagnosis.model,
        'bags': {
            'fit': [one.name for one in search.fitted.recordings],
            'verify': [one.name for one in search.held.recordings],
        },
        'seed': 0,
        'seconds': diagnosis.seconds,
        'verdict': diagnosis.verdict,
        'sentence': sentence(diagnosis),
        'where': where(search.fitted, diagnosis.part.hypothesis),
        'candidates': ranking(search),
        'indistinguishable': alike(diagnosis),
        'parameters': [row for one, row in _estimates(diagnosis) if not one.is_effect],
        'effects': [row for one, row in _estimates(diagnosis) if one.is_effect],
        'unknown': None,
        'gap': gap(diagnosis),
        'next_experiment': None,
    }


def sentence(diagnosis: PartDiagnosis) -> str:
    """Return the verdict in one sentence."""
    kind = diagnosis.part.kind
    left = f'{diagnosis.best.held:.1f} times the noise on the runs left out'
    if diagnosis.verdict == 'consistent':
        return f'Measured and modelled {kind} agree within the noise: nothing is missing.'
    if diagnosis.verdict == 'unknown':
        gap = 'and nothing in the library explains it'
        return f'Measured and modelled {kind} disagree ({left}), {gap}.'
    names = [
        f'{one.name} ({library.load(one.name).title})'
        if one.is_effect else f'{one.name} has another value'
        for one in diagnosis.best.explanation.parts
        if one.is_effect or diagnosis.verdict == 'parameter'
    ]  # fmt: skip
    start = 'The model lacks ' if diagnosis.verdict == 'effect' else 'A parameter is wrong: '
    rest = f'; there is a gap of {left} still' if diagnosis.best.worst > CONSISTENT else ''
    return start + ' and '.join(names) + rest + '.'


def where(evidence: PartEvidence, hypothesis: Hypothesis) -> list[dict[str, Any]]:
    """Return the signals and regimes that disagree significantly, as plain data."""
    rows: dict[tuple[str, int, str], list[tuple[str, Any, Any]]] = {}
    for recording, channels in zip(
        evidence.recordings, evidence.channels(hypothesis), strict=True
    ):
        for one in channels:
            for regime in range(len(REGIMES)):
                here = (recording.regimes == regime) & np.isfinite(one.gap)
                if here.any():
                    row = recording.name, one.gap[here], one.noise[here]
                    rows.setdefault((one.name, regime, one.unit), []).append(row)
    told = [_disagreement(*key, found) for key, found in rows.items()]
    significant = [row for row in told if row['significance'] > SIGNIFICANT]
    return sorted(significant, key=lambda row: -row['significance'])


def _disagreement(
    signal: str, regime: int, unit: str, found: list[tuple[str, Any, Any]]
) -> dict[str, Any]:
    rms = float(np.sqrt(np.mean(np.concatenate([gap for _, gap, _ in found]) ** 2)))
    noise = float(np.sqrt(np.mean(np.concatenate([noise for _, _, noise in found]) ** 2)))
    return {
        'balance': signal, 'regime': REGIMES[regime], 'unit': unit, 'rms': rms, 'noise': noise,
        'significance': rms / noise, 'bags': [name for name, _, _ in found], 'intervals': [],
    }  # fmt: skip


def ranking(search: PartSearch) -> list[dict[str, Any]]:
    """Return the candidates as plain data: fitted ones, best first, then those screened."""
    rows, seen = [], set()
    for one in sorted(search.scored, key=lambda one: one.held):
        parts, values = one.explanation.parts, one.explanation.values
        names = [part.name for part in parts]
        shown = [name for name in names if '.' not in name] or names
        if tuple(shown) in seen:
            continue
        seen.add(tuple(shown))
        fitted = {
            f'{part.name}.{c.name}' if part.is_effect else part.name: value
            for part, numbers in zip(parts, values, strict=True)
            for c, value in zip(part.coordinates, numbers, strict=True)
        }
        rows.append(_row(shown, 'fitted', one.held, search.given.held, fitted))
    rows += [
        _row([one.candidate.name], 'screened', one.gap, search.given.fitted, {})
        for one in search.screened if (one.candidate.name,) not in seen
    ]  # fmt: skip
    return rows[:MOST_CANDIDATES]


def _row(
    names: list[str], stage: str, level: float, start: float, values: dict[str, float]
) -> dict[str, Any]:
    left = _above(level) / max(_above(start), 1e-9)
    return {'names': names, 'stage': stage, 'cost': level, 'gap_left': left, 'parameters': values}


def _above(level: float) -> float:
    """Return what of a gap in noises the noise does not explain [-]."""
    return float(np.sqrt(max(level**2 - 1.0, 0.0)))


def alike(diagnosis: PartDiagnosis) -> list[list[str]]:
    """Return the effects that explain the recordings left out all but equally well."""
    best = diagnosis.best
    if not best.effects:
        return []
    rivals = [one for one in diagnosis.search.scored
              if len(one.effects) == len(best.effects) and one.effects != best.effects
              and one.held < (1.0 + ALIKE) * best.held]  # fmt: skip
    return [['+'.join(one.effects) for one in (best, *rivals)]] if rivals else []


def _estimates(diagnosis: PartDiagnosis) -> list[tuple[Candidate, dict[str, Any]]]:
    """Return each part of the explanation with its values and intervals as plain data."""
    fit, told = diagnosis.best.fit, []
    intervals = iter(fit.intervals() if fit.explanation.parts else [])
    for one, values in zip(fit.explanation.parts, fit.explanation.values, strict=True):
        rows = {
            c.name: {'value': value, 'interval': list(next(intervals)), 'unit': c.quantity.unit}
            for c, value in zip(one.coordinates, values, strict=True)
        }
        row: dict[str, Any]
        if one.is_effect:
            effect = library.load(one.name)
            row = {'name': one.name, 'title': effect.title, 'balance': one.balance,
                   'parameters': rows}  # fmt: skip
        else:
            row = {'name': one.name, 'was': one.was, **next(iter(rows.values()))}
        told.append((one, row))
    return told


def gap(diagnosis: PartDiagnosis) -> dict[str, Any]:
    """Return the gap on the recordings left out, before and after, as plain data."""
    held, part = diagnosis.search.held, diagnosis.part
    runs = [held.channels(one) for one in (part.hypothesis, diagnosis.improved.hypothesis)]
    before, after = _above(diagnosis.search.given.held), _above(diagnosis.best.held)
    nothing = {'unit': '-', 'measured': None, 'before': None, 'after': None}
    return {
        'before': before,
        'after': after,
        'cut': 1.0 - after / before if before > 0.0 else 0.0,
        'signals': _signals(runs[0], runs[1]),
        'cycles': nothing,
        'bags': [one.name for one in held.recordings],
    }


def _signals(before: list[list[Channel]], after: list[list[Channel]]) -> dict[str, Any]:
    """Return the RMSE of every signal over all recordings as plain data."""
    names = {one.name: one.unit for channels in before for one in channels}
    told = {}
    for name, unit in names.items():
        gaps = [
            np.concatenate([one.gap for channels in runs for one in channels if one.name == name])
            for runs in (before, after)
        ]
        noise = np.concatenate(
            [one.noise for channels in before for one in channels if one.name == name]
        )
        old, new, floor = (float(np.sqrt(np.nanmean(v**2))) for v in (*gaps, noise))
        told[name] = {'unit': unit, 'noise': floor, 'before': old, 'after': new}
    return told
