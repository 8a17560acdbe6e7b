"""What figures and tables share, and the figure of a stroke in the form of Fig. 4-6."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.rcsetup import cycler

from pneu_rig_ros.analysis.friction import friction_of
from pneu_rig_ros.analysis.motion import cycles_of
from pneu_rig_ros.analysis.velocity import velocity_of
from pneu_rig_ros.errors import printable
from pneu_rig_ros.records import Recording
from pneu_rig_ros.records.atomic_write import writing

BLUE, ORANGE, GREEN, GREY = '#1f5a94', '#d1660b', '#2c8a5a', '#8a8f98'
BAR = 1e5
"""[Pa]"""

STYLE: Any = {
    'font.size': 9.0,
    'axes.spines.top': False,
    'axes.spines.right': False,
    'axes.grid': True,
    'axes.prop_cycle': cycler(color=(BLUE, ORANGE, GREEN)),
    'axes.edgecolor': GREY,
    'axes.formatter.useoffset': False,
    'grid.color': '#e4e6ea',
    'grid.linewidth': 0.6,
    'lines.linewidth': 1.0,
    'legend.frameon': False,
    'xtick.color': '#3c4048',
    'ytick.color': '#3c4048',
    'xtick.major.size': 3.0,
    'ytick.major.size': 3.0,
    'path.simplify': True,
    'figure.constrained_layout.use': True,
}


class Signal(NamedTuple):
    """
    How a signal is shown.

    :param label: on an axis
    :param unit, scale: display unit, and how many of it are one SI unit; for differences, see
        ``display``
    """

    label: str
    unit: str
    scale: float

    @property
    def axis(self) -> str:
        """Label of an axis."""
        return f'{self.label} [{self.unit}]'


SIGNALS = {
    'position': Signal('position', 'mm', 1e3),
    'velocity': Signal('velocity', 'mm/s', 1e3),
    'pressure_1': Signal('pressure $p_1$', 'bar abs', 1e-5),
    'pressure_2': Signal('pressure $p_2$', 'bar abs', 1e-5),
    'friction': Signal('friction force', 'N', 1.0),
    'force': Signal('bench force', 'N', 1.0),
}

UNITS = {
    'm': ('mm', 1e3),
    'm/s': ('mm/s', 1e3),
    'Pa': ('kPa', 1e-3),
    'kg/s': ('mg/s', 1e6),
}


def display(unit: str) -> tuple[str, float]:
    """Return the display unit of an SI unit, and how many of it make one SI unit."""
    return UNITS.get(unit, (unit, 1.0))


def plain_name(name: str) -> str:
    """Return the name of a cylinder or a signal with blanks."""
    return name.replace('_', ' ')


def literal(text: str) -> str:
    """Return the text of anybody's file for a figure, which then sees no formula in it."""
    return printable(text).replace('$', r'\$')


def add_letter(axes: Axes, index: int, name: str = '') -> None:
    """Write (a), (b), ... and a name above a panel, where no curve is."""
    title = f'({"abcdefgh"[index]}) {name}'.strip()
    axes.set_title(title, loc='left', fontsize=9, fontweight='bold', pad=3)


def add_legend(axes: Axes) -> None:
    """Put a legend above the panel, where no curve is, each label once."""
    handles, labels = axes.get_legend_handles_labels()
    unique = dict(zip(labels, handles, strict=True))
    axes.legend(
        list(unique.values()),
        list(unique),
        loc='lower right',
        bbox_to_anchor=(1.0, 1.0),
        borderaxespad=0.0,
        borderpad=0.1,
        ncols=2,
    )


def save_png(figure: Figure, path: Path) -> Path:
    """
    Write a figure as PNG.

    :raises RigError: when the file cannot be written
    """
    with writing(f'the picture {path}'):
        figure.savefig(path, format='png')
    return path


QUANTITIES = ('position [mm]', 'velocity [mm/s]', 'pressure [bar abs]', 'friction force [N]')


def time_panels(
    size: tuple[float, float],
    labels: Sequence[str],
    start: float,
    end: float,
    dpi: float | None = None,
) -> tuple[Figure, list[Axes]]:
    """Return a figure of a size [inch] with a panel for each label, from start to end [s]."""
    figure = Figure(figsize=size, dpi=dpi)
    panels = list(figure.subplots(len(labels), 1, sharex=True, squeeze=False)[:, 0])
    for index, (axes, label) in enumerate(zip(panels, labels, strict=True)):
        axes.set_ylabel(label)
        add_letter(axes, index)
    panels[-1].set_xlabel('time [s]')
    # A little more than the recording, so that a tick at its very end is drawn.
    panels[-1].set_xlim(start, start + 1.002 * (end - start))
    figure.align_ylabels(panels)
    return figure, panels


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
    # A picture of a single sample has an axis, too.
    end = max(recording.duration, recording.interval)
    figure, panels = time_panels((8.0, 7.6), QUANTITIES, 0.0, end, dpi=120)
    position, velocity, pressures, force = panels
    figure.suptitle(title_of(recording), fontsize=10.5, x=0.01, ha='left')
    position.plot(time, 1e3 * recording.position)
    velocity.plot(time, 1e3 * velocity_of(recording.position, recording.interval))
    pressures.plot(time, recording.pressure_1 / BAR, label='$p_1$')
    pressures.plot(time, recording.pressure_2 / BAR, label='$p_2$')
    force.plot(time, friction, linewidth=0.8)
    if cycles:
        breakaways = [(cycle.breakaway_time, cycle.peak_friction) for cycle in cycles]
        force.plot(*zip(*breakaways, strict=True), 'v', markersize=4.5, label='breakaway')
        add_legend(force)
    add_legend(pressures)
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
