"""Parts of real hardware, measured by others: the effects that are known to be there are named."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pneu_rig_ros.gap.parts.diagnosis import answer, diagnose_part

ROOT = Path(__file__).resolve().parents[2]
PARTS = ROOT / 'config' / 'parts'
DATA = ROOT.parent / 'shared' / 'data'

pytestmark = pytest.mark.skipif(
    not (DATA / 'sealed_chambers').is_dir(), reason=f'no measured data in {DATA}'
)


def seal(name: str, model: str) -> dict[str, Any]:
    """Return the answer for a seal: fitted at 3 and 5 bar, judged at 1 and 7 bar."""
    runs = {bar: DATA / 'seal_friction' / f'{name}_{bar}bar.csv' for bar in (1, 3, 5, 7)}
    return answer(
        diagnose_part(
            [runs[3], runs[5]],
            PARTS / model,
            PARTS / 'seal_friction.map.yaml',
            [runs[1], runs[7]],
        )
    )


def test_sealed_chambers_lack_heat_transfer() -> None:
    folder = DATA / 'sealed_chambers'
    found = diagnose_part(
        [folder / '2021.07.26T10.51.44.exp'], PARTS / 'sealed_chambers.yaml',
        PARTS / 'sealed_chambers.map.yaml', [folder / '2022.01.28T16.46.31.exp'],
    )  # fmt: skip
    told = answer(found)
    assert told['verdict'] == 'effect'
    assert told['effects'][0]['name'] == 'wall_heat_transfer'
    assert told['gap']['cut'] > 0.6
    assert told['gap']['signals']['pressure_1']['after'] < 14e3
    assert told['gap']['signals']['pressure_2']['after'] < 14e3


def test_lip_seal_lacks_friction_that_grows_with_pressure() -> None:
    told = seal('NAPN', 'seal_NAPN.yaml')
    assert told['verdict'] == 'effect'
    assert told['effects'][0]['name'] == 'pressure_dependent_friction'
    # half the width of the measured loops is 3.3, 7.0 and 12.0 N at 1, 3 and 7 bar: 1.25e-5 N/Pa
    # between the higher two and 1.85e-5 N/Pa between the lower two
    assert 1.1e-5 < told['effects'][0]['parameters']['slope']['value'] < 1.9e-5
    assert told['gap']['cut'] > 0.5
