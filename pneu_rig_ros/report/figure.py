"""One stroke as a picture in the form of Fig. 4-6 of the paper."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from pneu_rig_ros.analysis.friction import Floats, friction_of
from pneu_rig_ros.analysis.motion import cycles_of
from pneu_rig_ros.analysis.velocity import velocity_of
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records import Recording

BLUE, ORANGE, GREY = '#1f5a94', '#d1660b', '#8a8f98'
BAR = 1e5
"""[Pa]"""

STYLE: Any = {
    'font.size': 9.0,
    'axes.spines.top': False,
    'axes.spines.right': False,
    'axes.grid': True,
    'axes.edgecolor': GREY,
    'grid.color': '#e4e6ea',
    'grid.linewidth': 0.6,
    'lines.linewidth': 1.0,
    'xtick.color': '#3c4048',
    'ytick.color': '#3c4048',
    'path.simplify': True,
}


def draw_stroke(recording: Recording, path: Path | str) -> Path:
    """
    Write a PNG with (a) position, (b) velocity, (c) pressures, (d) friction force against time.

    Position and absolute pressures as measured; velocity smoothed over 46 ms; friction by Eq. 2
    with the zero-phase filter, and the breakaway of each stick-slip cycle marked.

    :raises RigError: when the recording does not say what rig it is of, or the file cannot be
        written
    """
    path = Path(path)
    friction = friction_of(recording)
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(8.0, 7.6), dpi=120, layout='constrained')
        FigureCanvasAgg(figure)
        axes = figure.subplots(4, 1, sharex=True)
        figure.suptitle(title_of(recording), fontsize=10.5, x=0.01, ha='left')
        _draw_motion(axes[0], axes[1], recording)
        _draw_pressures(axes[2], recording)
        _draw_friction(axes[3], recording, friction)
        axes[3].set_xlabel('time [s]')
        # A little more than the recording, so that a tick at its very end is drawn.
        axes[3].set_xlim(0.0, 1.002 * max(recording.duration, recording.interval))
        figure.align_ylabels(axes)
        try:
            figure.savefig(path, format='png')
        except OSError as error:
            raise RigError(f'cannot write the picture {path}: {error.strerror}') from error
    return path


def title_of(recording: Recording) -> str:
    """Return the operating point as the captions of Fig. 4-6 give it, supply pressure absolute."""
    configuration = recording.configuration
    assert configuration is not None
    operation = configuration.model.operation
    supply = operation.supply_pressure / BAR
    u = ''
    if recording.driven:
        drive = (recording.voltage_1 - recording.voltage_2) / 2
        u = f'u = {drive[np.abs(drive).argmax()]:.2f} V, '
    name = configuration.name.replace('_', ' ').capitalize()
    model = recording.metadata.get('friction_model', '')
    values = f'{u}$p_s$ = {supply:g} bar abs, load {operation.load_mass:g} kg'
    return f'{name}: {values}' + (f' ({model})' if model else '')


def _draw_motion(position: Axes, velocity: Axes, recording: Recording) -> None:
    position.plot(recording.time, 1e3 * recording.position, color=BLUE)
    _label(position, '(a)', 'position [mm]')
    speed = velocity_of(recording.position, recording.interval)
    velocity.plot(recording.time, 1e3 * speed, color=BLUE)
    _label(velocity, '(b)', 'velocity [mm/s]')


def _draw_pressures(axes: Axes, recording: Recording) -> None:
    axes.plot(recording.time, recording.pressure_1 / BAR, color=BLUE, label='$p_1$')
    axes.plot(recording.time, recording.pressure_2 / BAR, color=ORANGE, label='$p_2$')
    axes.legend(loc='upper right', ncols=2, frameon=False, borderaxespad=0.0)
    axes.margins(y=0.18)
    _label(axes, '(c)', 'pressure [bar abs]')


def _draw_friction(axes: Axes, recording: Recording, friction: Floats) -> None:
    axes.plot(recording.time, friction, color=BLUE, linewidth=0.8)
    cycles = cycles_of(recording, friction)
    times = [cycle.breakaway_time for cycle in cycles]
    peaks = [cycle.peak_friction for cycle in cycles]
    if cycles:
        axes.plot(times, peaks, 'v', color=ORANGE, markersize=4.5, label='breakaway')
        axes.legend(loc='upper right', frameon=False, borderaxespad=0.0)
        axes.margins(y=0.18)
    _label(axes, '(d)', 'friction force [N]')


def _label(axes: Axes, letter: str, quantity: str) -> None:
    axes.set_ylabel(quantity)
    axes.tick_params(length=3)
    axes.annotate(
        letter, (0.008, 0.97), xycoords='axes fraction', va='top', fontweight='bold'
    )  # fmt: skip
