"""Recordings from real hardware, where the folder with them is present."""

from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.records import read_recording

DATA = Path(__file__).resolve().parents[3] / 'shared' / 'data'
pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason=f'no measured data in {DATA}')

SEALS = {
    'time': {'column': 1, 'unit': 'ms'},
    'position': {'column': 5, 'unit': 'mm'},
    'pressure_1': {'column': 6, 'unit': 'bar', 'gauge': True},
    'force': {'column': 7, 'unit': 'N'},
    'skip_rows': 15,
}
CHAMBERS = {
    'time': 'time(s)',
    'position': 'Pos(in)',
    'pressure_1': 'LowerSpringPressure(psia)',
    'pressure_2': {'column': 'UpperSpringPressure(psia)'},
}


def files(pattern: str) -> list[Path]:
    return sorted(DATA.glob(pattern))


@pytest.mark.parametrize('path', files('seal_friction/*.csv'), ids=lambda path: path.stem)
def test_headerless_table_of_a_seal(path: Path) -> None:
    table = read_recording(path, SEALS)
    gauge = float(path.stem.split('_')[1].removesuffix('bar')) * 1e5
    assert table['pressure_1'].mean() == pytest.approx(1e5 + gauge, rel=0.01)
    assert np.ptp(table['position']) > 0.01
    assert table.interval == pytest.approx(0.01)
    assert 'interpolated onto steps of 10 ms' in table.notes[-1]


@pytest.mark.parametrize('path', files('sealed_chambers/*.exp'), ids=lambda path: path.stem)
def test_header_in_a_comment_inches_and_absolute_psi(path: Path) -> None:
    table = read_recording(path, CHAMBERS)
    assert table.notes == ()
    assert table.interval == pytest.approx(0.02)
    assert 0.0 <= table['position'].min() < table['position'].max() <= 2.03
    first = [float(text) for text in path.read_text().splitlines()[1].split()]
    assert table['position'][0] == pytest.approx(first[1] * 0.0254)
    assert table['pressure_1'][0] == pytest.approx(first[12] * 6894.757, rel=1e-6)
    assert table['pressure_2'][0] == pytest.approx(first[13] * 6894.757, rel=1e-6)
