"""Tasks for the executors; their processes import them by name."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.sweep import measure

STROKES = 16
"""Of a task."""
LONGEST = 20.0
"""A stroke is given up after this time [s]."""


def strokes(number: int) -> list[str]:
    """Simulate some strokes of cylinder 2, others for each number; repr is exact to the bit."""
    rig, names = load_configuration('cylinder_2'), ('u', 'load_mass')
    points = [(0.3 + 1e-3 * number, 0.2 + 0.04 * k) for k in range(STROKES)]
    return list(map(repr, measure(points, rig, names, LONGEST)))


def strokes_with_a_kill(number: int, journal: Path, fatal: int) -> list[str]:
    """
    Simulate strokes and enter the number in the journal; the fatal task kills its worker once.

    It dies when the work is done and the result not yet sent: where it costs most.
    """
    with journal.open('a') as file:  # one short line is written in one piece
        file.write(f'{number}\n')
    done = strokes(number)
    if number == fatal and journal.read_text().split().count(str(fatal)) == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return done


def count(seconds: float) -> int:
    """Count as far as possible in a time [s]: what a processor gives just now."""
    end, reached = time.perf_counter() + seconds, 0
    while time.perf_counter() < end:
        reached += 1
    return reached
