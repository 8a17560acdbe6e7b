"""Tasks that are shared out to measure the sharing out; workers import them by name."""

from __future__ import annotations

import hashlib
import os
import pickle
import signal
import sys
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.sweep.run import Setting, measure

ROOT = Path(__file__).resolve().parents[2]
BLOCK = 16
"""Strokes of a task."""
LONGEST = 20.0
"""A stroke is given up after this time [s]."""


class Done(NamedTuple):
    """
    What a task gave.

    :param seconds: that it took, without its way there and back
    :param digest: of its result, exact to the last bit
    :param size: of the result on its way [byte]
    """

    seconds: float
    digest: str
    size: int


def strokes(number: int) -> Done:
    """Simulate some strokes of cylinder 2 and look at them; other commands for each number."""
    begin = time.perf_counter()
    setting = Setting(load_configuration('cylinder_2'), ('u', 'load_mass'), LONGEST)
    points = [(0.3 + 1e-3 * number, 0.2 + 0.04 * k) for k in range(BLOCK)]
    result = measure(points, setting)
    return _done(begin, result)


def recorded_strokes(number: int, journal: Path, fatal: int) -> Done:
    """
    Simulate strokes, having told the journal; the fatal task kills its worker the first time.

    The kernel kills it when the work is done and not yet told: where it costs most.
    """
    with journal.open('a') as file:  # one short line is written in one piece
        file.write(f'{number}\n')
    done = strokes(number)
    if number == fatal and journal.read_text().split().count(str(fatal)) == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return done


def trial(number: int) -> Done:
    """Carry out a blind trial: hide an effect, record bags, diagnose them."""
    sys.path.insert(0, str(ROOT / 'test'))
    from blind.answers import carry_out  # type: ignore[import-not-found]
    from blind.trials import matrix  # type: ignore[import-not-found]

    begin = time.perf_counter()
    return _done(begin, carry_out(matrix()[number]))


def _done(begin: float, result: Any) -> Done:
    end = time.perf_counter()
    return Done(end - begin, digest(result), len(pickle.dumps(result)))


def nothing(number: int) -> int:
    """Return the number: what is left is the way there and back."""
    return number


def megabytes(count: int) -> Any:
    """Return an array of so many MB."""
    return np.zeros(count * 1_000_000, dtype=np.uint8)


def spin(seconds: float) -> int:
    """Count as far as possible in a time [s]: what a processor gives just now."""
    end, count = time.perf_counter() + seconds, 0
    while time.perf_counter() < end:
        count += 1
    return count


def digest(result: Any) -> str:
    """Return a hash of plain data; the text of a float is exact."""
    return hashlib.sha256(repr(result).encode()).hexdigest()[:16]
