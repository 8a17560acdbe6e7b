"""A picture of the factor by which an effect differs from its formula."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from pneu_rig_ros.report.diagnosis_rows import UNITS
from pneu_rig_ros.report.figure import BLUE, GREY, STYLE


def draw_shape(name: str, shape: Mapping[str, Any]) -> Figure:
    """
    Return the picture of a factor.

    :param name: of the effect
    :param shape: ``shape`` of an effect in diagnosis.json
    """
    unit, scale = UNITS.get(shape['unit'], (shape['unit'], 1.0))
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 2.8), dpi=120, layout='constrained')
        axes = figure.subplots()
        axes.plot(np.array(shape['x']) * scale, shape['y'], 'o-', color=BLUE)
        axes.axhline(1.0, color=GREY, linestyle='--')
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel(f'{shape["variable"].replace("_", " ")} [{unit}]')
        axes.set_ylabel(f'factor on {name} [-]')
    return figure
