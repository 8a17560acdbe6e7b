"""One bag as a self-contained interactive HTML page."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import Recording
from pneu_rig_ros.records.atomic_write import atomic_write
from pneu_rig_ros.records.description import git_revision
from pneu_rig_ros.report.view_data import page_data, span_of
from pneu_rig_ros.web.page import render

BAR = 1e5
"""[Pa]"""


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
    if span.end - span.first < 2:
        raise RigError(_nothing_there(start or 0.0, stop, recording.duration))
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
        version=version('pneu_rig_ros'),
        revision=git_revision(),
    )
    return atomic_write(path, text)


def _nothing_there(start: float, stop: float | None, end: float) -> str:
    """Say why there is nothing to show from start to stop [s] of what ends at `end`."""
    if start >= end:
        return f'no samples from {start:g} s on: the record ends at {end:.6g} s'
    last = end if stop is None else stop
    return f'under 2 samples from {start:g} to {last:.6g} s: the record goes from 0 to {end:.6g} s'


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
    rig = [recording.configuration.name.replace('_', ' ')]
    law = recording.metadata.get('friction_model')
    rig += [law.replace('_', ' ')] if law else []
    rig += [
        f'supply {model.operation.supply_pressure / BAR:g} bar abs',
        f'load {model.operation.load_mass:g} kg',
    ]
    return rig + texts
