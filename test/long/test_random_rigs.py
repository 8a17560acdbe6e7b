"""Random rigs: finite values, pressures and positions that can be, and balances of energy."""

from __future__ import annotations

import multiprocessing
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest

from .outcome import outcome

pytestmark = pytest.mark.long

COUNT = 10_000
"""Of the rigs, unless `--rigs` is given."""


def test_random_rigs_do_what_is_possible(request: pytest.FixtureRequest) -> None:
    count = request.config.getoption('rigs') or COUNT
    with ProcessPoolExecutor(mp_context=multiprocessing.get_context('spawn')) as pool:
        outcomes = list(pool.map(outcome, range(count), chunksize=10))
    worst = [
        max(o.residuals.gas for o in outcomes),
        max(o.residuals.created for o in outcomes),
        min(o.residuals.dissipated for o in outcomes),
    ]
    levels = np.bincount([o.level for o in outcomes], minlength=4)
    print(
        f'\n{count} random rigs; at worst, as a share of the energy moved: gas {worst[0]:.1e}, '
        f'created {worst[1]:.1e}, dissipated {worst[2]:.1e}'
    )
    print(
        f'finer samples in {levels[1:3].sum()}, finer steps in {levels[3]}; steps: median '
        f'{np.median([o.steps for o in outcomes]):.0f}, most {max(o.steps for o in outcomes)}; '
        f'longest {max(o.seconds for o in outcomes):.2f} s'
    )
    assert {o.seed: o.problems for o in outcomes if o.problems} == {}
