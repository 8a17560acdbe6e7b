"""What a publisher keeps for subscribers that were killed is bounded."""

from __future__ import annotations

import os
import signal

import psutil
import pytest

from .live_rig import ProcessRig
from .witness import Witness

pytestmark = [pytest.mark.long, pytest.mark.live, pytest.mark.usefixtures('apart')]

KILLS, BETWEEN_KILLS = 50, 4.0
"""Of the recorder, unless `--kills` is given, and the time from one to the next [s]."""
LARGEST_GROWTH_MB, LATE_GROWTH_MB = 50.0, 5.0
"""Of the memory of a node by these kills, and of that in the second half of them [MB]."""


def memory_mb(rig: ProcessRig) -> dict[str, float]:
    """Return the memory of each node but the recorder, without pages of files [MB]."""
    held = {
        name: psutil.Process(node.process.pid).memory_info()
        for name, node in rig.nodes.items()
        if name != 'recorder'
    }
    return {name: (memory.rss - memory.shared) / 1e6 for name, memory in held.items()}


def test_memory_is_bounded_however_often_the_recorder_is_killed(
    rig: ProcessRig, witness: Witness, request: pytest.FixtureRequest
) -> None:
    kills = int(request.config.getoption('kills') or KILLS)
    held = [memory_mb(rig)]
    for _ in range(kills):
        os.kill(rig.nodes['recorder'].process.pid, signal.SIGKILL)
        witness.until(rig.nodes['recorder'].revive, 'the recorder can be restarted')
        witness.listen(BETWEEN_KILLS)
        witness.received.clear()
        held.append(memory_mb(rig))
    start, half, end = held[0], held[len(held) // 2], held[-1]
    for name in start:
        print(f'\n{name}: {start[name]:.1f} MB, after {kills} kills {end[name]:.1f} MB', end='')
        assert end[name] - start[name] < LARGEST_GROWTH_MB, name
        assert end[name] - half[name] < LATE_GROWTH_MB, name
