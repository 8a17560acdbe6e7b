"""One bag as a self-contained interactive HTML page."""

import base64
from pathlib import Path
from typing import Any

import numpy as np

from pneu_rig_ros.analysis.friction import known_friction
from pneu_rig_ros.analysis.motion import cycles_of
from pneu_rig_ros.analysis.regimes import regimes_of
from pneu_rig_ros.analysis.velocity import velocity_of
from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.effect import Regime
from pneu_rig_ros.records import Recording
from pneu_rig_ros.records.atomic_write import atomic_write
from pneu_rig_ros.records.description import git_revision, package_version
from pneu_rig_ros.web import render

MOST_POINTS = 110_000
"""Points of one signal on a page: 127 s at 862 Hz, and 4.7 MB of eight signals."""

Span = tuple[int, int]
"""The samples of a recording that a page shows: the first, and the one after the last."""


def span_of(recording: Recording, start: float | None, stop: float | None) -> Span:
    """Return the samples from start to stop [s since the first one]; None is an end."""
    last = recording.position.size
    first = 0 if start is None else round(start / recording.interval)
    end = last if stop is None else round(stop / recording.interval) + 1
    return min(max(first, 0), last), min(max(end, 0), last)


def page_data(recording: Recording, span: Span) -> dict[str, Any]:
    """
    Return what the scripts of the page need, SI units, times since the first sample shown [s].

    Friction and regimes need Eq. 2, and the drawing a rig that is known.
    """
    first, end = span
    friction = known_friction(recording)
    stride = -(-2 * (end - first) // MOST_POINTS) if end - first > MOST_POINTS else 1
    return {
        'step': recording.interval * (stride / 2 if stride > 1 else 1),
        'duration': (end - first - 1) * recording.interval,
        'stride': stride,
        'signals': {
            name: _encoded(thinned(values[first:end], stride))
            for name, values in _signals(recording, friction).items()
        },
        'cycles': _cycles(recording, friction, span),
        'regimes': _regimes(recording, span) if friction is not None else [],
        'regime_names': [regime.label for regime in Regime],
        'rig': recording.configuration.geometry() if recording.configuration else None,
    }


def _encoded(values: Floats) -> str:
    """Return 32-bit floats, little-endian, as base64."""
    return base64.b64encode(values.astype('<f4').tobytes()).decode('ascii')


def thinned(values: Floats, stride: int) -> Floats:
    """
    Return smallest and largest of every `stride` samples, in the order in which they came.

    :param values: shape (n,)
    :param stride: 1 leaves all of them
    :return: shape (n,) for stride 1, else (2 ceil(n / stride),)
    """
    if stride == 1:
        return values
    padded = np.pad(values, (0, -values.size % stride), mode='edge').reshape(-1, stride)
    ends = np.sort(np.stack([padded.argmin(axis=1), padded.argmax(axis=1)]), axis=0)
    return np.asarray(np.take_along_axis(padded, ends.T, axis=1).ravel())


def _signals(recording: Recording, friction: Floats | None) -> dict[str, Floats]:
    signals = {
        'position': recording.position,
        'velocity': recording.velocity,
        'velocity_fit': velocity_of(recording.position, recording.interval),
        'pressure_1': recording.pressure_1,
        'pressure_2': recording.pressure_2,
    }
    if friction is not None:
        signals['friction'] = friction
    if recording.driven:
        signals |= {'voltage_1': recording.voltage_1, 'voltage_2': recording.voltage_2}
    return signals


def _cycles(
    recording: Recording, friction: Floats | None, span: Span
) -> list[dict[str, float | None]]:
    """Return the cycles whose breakaway is shown, times since the first sample shown."""
    start, stop = (sample * recording.interval for sample in span)
    return [
        {**cycle.to_dict(), 'breakaway_time': cycle.breakaway_time - start}
        for cycle in cycles_of(recording, friction)
        if start <= cycle.breakaway_time < stop
    ]


def _regimes(recording: Recording, span: Span) -> list[tuple[float, int]]:
    """Return when each stretch of one regime begins [s since the first shown], and which."""
    regime = regimes_of(recording)[slice(*span)]
    begins = np.flatnonzero(np.diff(regime, prepend=-1))
    return [(float(k * recording.interval), int(regime[k])) for k in begins]


def write_view(
    path: Path,
    recording: Recording,
    title: str,
    start: float | None = None,
    stop: float | None = None,
) -> Path:
    """
    Write the page of a recording.

    :param title: what to call it
    :param start: of the part to show [s since the first sample], None for the beginning
    :param stop: its end [s], None for that of the recording
    :raises RigError: when there is nothing between start and stop, or the file cannot be written
    """
    span = span_of(recording, start, stop)
    if span[1] - span[0] < 2:
        begin, end = start or 0.0, recording.duration
        if begin >= end:
            raise RigError(f'no samples from {begin:g} s on: the record ends at {end:.6g} s')
        last = end if stop is None else stop
        few = f'under 2 samples from {begin:g} to {last:.6g} s'
        raise RigError(f'{few}: the record goes from 0 to {end:.6g} s')
    data = page_data(recording, span)
    text = render(
        'view.html',
        data,
        title=title,
        facts=facts(recording),
        regime_names=data['regime_names'] if data['regimes'] else (),
        thinned=data['stride'] if data['stride'] > 1 else 0,
        geometry=data['rig'] is not None,
        duration=data['duration'],
        cycles=len(data['cycles']),
        version=package_version(),
        revision=git_revision(),
    )
    return atomic_write(path, text)


def facts(recording: Recording) -> list[str]:
    """Return the operating point and the size of a recording as text."""
    texts = [f'{recording.duration:.2f} s, a sample every {1e3 * recording.interval:g} ms']
    if recording.driven:
        drive = (recording.voltage_1 - recording.voltage_2) / 2.0
        ends = [f'{u:.2f}' for u in (drive.min(), drive.max())]
        texts.insert(0, f'u = {" to ".join(dict.fromkeys(ends))} V')
    if recording.configuration is None:
        return texts
    model = recording.configuration.model
    law = recording.metadata.get('friction_model')
    return [
        recording.configuration.name.replace('_', ' '),
        *([law.replace('_', ' ')] if law else []),
        f'supply {1e-5 * model.operation.supply_pressure:g} bar abs',
        f'load {model.operation.load_mass:g} kg',
        *texts,
    ]
