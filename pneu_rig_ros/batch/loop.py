"""
The compiled loop over plants, one for each kind of plant, kept on disk beside the plant.

It calls the compiled run of the plant itself, so that the numbers are those of a run alone, to
the last bit, and a change of the loop compiles no plant again.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache

from pneu_rig_ros.batch.layout import PackedParameters, alias
from pneu_rig_ros.model.assembly import kept_module

Loop = Callable[..., None]

_TEMPLATE = '''"""Loop over compiled plants; made by pneu_rig_ros, may be deleted."""

from numba import njit, prange

from pneu_rig_ros.model.integrator import IntegratorState
from {plant} import run
{imports}


@njit(cache=True, parallel=True, error_model='numpy', nogil=True)
def loop(
    rows, arrays, clock, counts, y0, f0, y1, f1, arrow, memory, held, scale, work, work_arrow,
    interval, first, voltages, actions, measured, rests, states, extras, tolerance, longest,
):
    for i in prange(len(rows)):
        row = rows[i]
        model, effects = {code}
        carry = IntegratorState(
            clock[i], counts[i], y0[i], f0[i], y1[i], f1[i], arrow[i], memory[i], held[i],
            scale[i], work[i], work_arrow[i],
        )
        run(
            carry, interval, first, voltages[i % len(voltages)], actions[i % len(actions)],
            measured[i % len(measured)], rests[i % len(rests)], states[i], extras[i], tolerance,
            longest, model, effects,
        )
'''


def loop_over(plant: str, packed: PackedParameters) -> Loop:
    """
    Return the compiled loop.

    :param plant: module of the compiled plant
    :param packed: model and effects of one of the plants
    """
    imports = ''.join(
        f'from {module} import {name} as {alias(module, name)}\n'
        for module, name in sorted(packed.classes)
    )
    return _loop(plant, _TEMPLATE.format(plant=plant, imports=imports, code=packed.code))


@cache
def _loop(plant: str, text: str) -> Loop:
    digest = hashlib.sha256(text.encode()).hexdigest()[:16]
    loop: Loop = kept_module(f'loop_{digest}', text).loop
    return loop
