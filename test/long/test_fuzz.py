"""Damaged input on every reader, each in a process whose time and memory are limited."""

from __future__ import annotations

import multiprocessing
import resource
import time
from pathlib import Path

import hypothesis
import pytest

from .attempt import Tally, attempt, inputs, limit_memory
from .readers import READERS

pytestmark = pytest.mark.long

MINUTES = 10.0
"""Of all readers together, unless `--minutes` is given."""
START_UP = 240.0
"""On a busy machine a process may need so much longer than the time for its inputs [s]."""


@pytest.mark.parametrize('name', READERS)
def test_damaged_input_is_refused_in_one_line_or_read_right(
    name: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    minutes = request.config.getoption('minutes') or MINUTES
    seconds = 60.0 * minutes / len(READERS)
    # Spawned, so that a crash, a hang or lack of memory ends no more than that process.
    process = multiprocessing.get_context('spawn').Process(
        target=try_inputs, args=(name, seconds, tmp_path)
    )
    process.start()
    process.join(seconds + START_UP)
    hangs = process.is_alive()
    process.kill()
    assert not hangs, f'hangs with the input {tmp_path / "input"}'
    assert process.exitcode == 0, f'the last input is {tmp_path / "input"}'


def try_inputs(name: str, seconds: float, folder: Path) -> None:
    """Try damaged inputs for so long [s], once all is loaded."""
    tally = Tally()
    for seed in READERS[name].seeds():
        attempt(name, seed, folder, tally)
    assert tally.refused == 0

    @hypothesis.settings(
        max_examples=100,
        phases=[hypothesis.Phase.generate],
        deadline=None,
        database=None,
        suppress_health_check=list(hypothesis.HealthCheck),
    )
    @hypothesis.given(inputs(name))
    def try_one(data: bytes) -> None:
        (folder / 'input').write_bytes(data)
        attempt(name, data, folder, tally)

    limit_memory()
    number, end = 0, time.monotonic() + seconds
    while time.monotonic() < end:
        hypothesis.seed(number)(try_one)()
        number += 1
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f'\n{name}: {tally.read + tally.refused} inputs, {tally.refused} refused, slowest '
        f'{tally.slowest:.2f} s, peak memory {peak:.0f} MB'
    )
    assert tally.refused > 0
