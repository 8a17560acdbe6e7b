"""What all figures share, and the figure of a stroke in the form of Fig. 4-6 of the paper."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pneu_rig_ros.analysis.friction import friction_of
from pneu_rig_ros.analysis.motion import cycles_of
from pneu_rig_ros.analysis.velocity import velocity_of
from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.errors import RigError, printable
from pneu_rig_ros.records import Recording

BLUE, ORANGE, GREEN, GREY = '#1f5a94', '#d1660b', '#2c8a5a', '#8a8f98'
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
    'legend.frameon': False,
    'xtick.color': '#3c4048',
    'ytick.color': '#3c4048',
    'xtick.major.size': 3.0,
    'ytick.major.size': 3.0,
    'path.simplify': True,
}
MOST_POINTS = 3000
"""Longer curves are drawn by their smallest and largest values, which looks the same."""


class Signal(NamedTuple):
    """
    How a signal is shown.

    :param label: on an axis
    :param unit, scale: display unit, and how many of it are one SI unit
    :param difference_unit, difference_scale: the same for differences
    """

    label: str
    unit: str
    scale: float
    difference_unit: str
    difference_scale: float


SIGNALS = {
    'position': Signal('position', 'mm', 1e3, 'mm', 1e3),
    'velocity': Signal('velocity', 'mm/s', 1e3, 'mm/s', 1e3),
    'pressure_1': Signal('pressure $p_1$', 'bar abs', 1e-5, 'kPa', 1e-3),
    'pressure_2': Signal('pressure $p_2$', 'bar abs', 1e-5, 'kPa', 1e-3),
    'friction': Signal('friction force', 'N', 1.0, 'N', 1.0),
    'force': Signal('bench force', 'N', 1.0, 'N', 1.0),
}


def plain_name(name: str) -> str:
    """Return the name of a cylinder or a signal with blanks."""
    return name.replace('_', ' ')


def literal(text: str) -> str:
    """Return the text of anybody's file for a figure, which then sees no formula in it."""
    return printable(text).replace('$', r'\$')


def thinned(time: Floats, values: Floats) -> tuple[Floats, Floats]:
    """
    Return a curve with at most :data:`MOST_POINTS` points: extremes of equal stretches.

    :param time, values: shape (n,)
    :return: both of shape (m,)
    """
    if values.size <= MOST_POINTS:
        return time, values
    stretches = np.array_split(np.arange(values.size), MOST_POINTS // 2)
    extremes = [(part[values[part].argmin()], part[values[part].argmax()]) for part in stretches]
    kept = np.unique(extremes)
    return time[kept], values[kept]


def add_letter(axes: Axes, index: int) -> None:
    """Write (a), (b), ... into the corner of a panel."""
    axes.annotate(
        f'({"abcdefgh"[index]})',
        (0.008, 0.97),
        xycoords='axes fraction',
        va='top',
        fontweight='bold',
    )


def save_png(figure: Figure, path: Path) -> Path:
    """
    Write a figure as PNG.

    :raises RigError: when the file cannot be written
    """
    try:
        figure.savefig(path, format='png')
    except OSError as error:
        raise RigError(f'cannot write the picture {path}: {error.strerror}') from error
    return path


@matplotlib.rc_context(STYLE)
def draw_stroke(recording: Recording, path: Path | str) -> Path:
    """
    Write a PNG with (a) position, (b) velocity, (c) pressures, (d) friction force against time.

    Position and absolute pressures as measured; velocity smoothed over 46 ms; friction by Eq. 2
    with the zero-phase filter, and the breakaway of each stick-slip cycle marked.

    :raises RigError: when the recording does not say what rig it is of, or the file cannot be
        written
    """
    friction = friction_of(recording)
    cycles = cycles_of(recording, friction)
    time = recording.time
    figure = Figure(figsize=(8.0, 7.6), dpi=120, layout='constrained')
    figure.suptitle(title_of(recording), fontsize=10.5, x=0.01, ha='left')
    position, velocity, pressures, force = panels = figure.subplots(4, 1, sharex=True)
    position.plot(time, 1e3 * recording.position, color=BLUE)
    smoothed_velocity = velocity_of(recording.position, recording.interval)
    velocity.plot(time, 1e3 * smoothed_velocity, color=BLUE)
    pressures.plot(time, recording.pressure_1 / BAR, color=BLUE, label='$p_1$')
    pressures.plot(time, recording.pressure_2 / BAR, color=ORANGE, label='$p_2$')
    force.plot(time, friction, color=BLUE, linewidth=0.8)
    if cycles:
        breakaways = [cycle.breakaway_time for cycle in cycles]
        peaks = [cycle.peak_friction for cycle in cycles]
        force.plot(breakaways, peaks, 'v', color=ORANGE, markersize=4.5, label='breakaway')
    for axes in (pressures, force) if cycles else (pressures,):
        axes.legend(loc='upper right', ncols=2, borderaxespad=0.0)
        axes.margins(y=0.18)
    quantities = ('position [mm]', 'velocity [mm/s]', 'pressure [bar abs]', 'friction force [N]')
    for index, (axes, quantity) in enumerate(zip(panels, quantities, strict=True)):
        axes.set_ylabel(quantity)
        add_letter(axes, index)
    force.set_xlabel('time [s]')
    # A little more than the recording, so that a tick at its very end is drawn.
    force.set_xlim(0.0, 1.002 * max(recording.duration, recording.interval))
    figure.align_ylabels(panels)
    return save_png(figure, Path(path))


def title_of(recording: Recording) -> str:
    """Return the operating point as the captions of Fig. 4-6 give it, supply pressure absolute."""
    configuration = recording.configuration
    assert configuration is not None
    operation = configuration.model.operation
    u = ''
    if recording.driven:
        drive = (recording.voltage_1 - recording.voltage_2) / 2
        u = f'u = {drive[np.abs(drive).argmax()]:.2f} V, '
    supply = f'$p_s$ = {operation.supply_pressure / BAR:g} bar abs'
    title = f'{literal(plain_name(configuration.name)).capitalize()}: {u}{supply}'
    law = literal(recording.metadata.get('friction_model', ''))
    return f'{title}, load {operation.load_mass:g} kg' + (f' ({law})' if law else '')
