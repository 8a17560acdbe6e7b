"""Recordings from real hardware, where the folder with them is present."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from pneu_rig_ros.records import read_recording

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT.parent / 'shared' / 'data'
SYSTEMS = ROOT / 'config' / 'systems'
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
    assert 'interpolated onto steps of 10 ms' in table.notes[-2]
    assert table.notes[-1].endswith(' samples are missing')


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


@pytest.mark.parametrize(
    ('name', 'sign'), [('2021.07.26T10.51.44', -1), ('2022.01.28T16.46.31', 1)]
)
def test_third_balance_of_the_sealed_chambers_closes(name: str, sign: int) -> None:
    """
    Forces of gas, test machine and hydraulic piston add up to friction and some 0.3 kN.

    The sensor of the lower hydraulic pressure has the wrong sign in 2022.
    """
    mapping = yaml.safe_load((SYSTEMS / 'sealed_chambers_force.map.yaml').read_text())
    mapping['force'][2]['scale'] = f'{sign * 9.4e-4} m^2'
    table = read_recording(DATA / 'sealed_chambers' / f'{name}.exp', mapping)
    gas = 0.0127 * (table['pressure_1'] - 1e5) - 0.0115 * (table['pressure_2'] - 1e5)
    rest = table['force'] + gas
    viscous = np.polyval(np.polyfit(table.velocity, rest, 1), table.velocity)
    assert np.std(table['force']) > 3e3
    assert np.std(rest - viscous) < 700.0


@pytest.mark.parametrize('path', files('chamber_leak/*.csv'), ids=lambda path: path.stem)
def test_points_between_thousands_of_microseconds(path: Path) -> None:
    table = read_recording(path, SYSTEMS / 'chamber_leak.map.yaml')
    last = path.read_text().splitlines()[-1].split(';')
    assert table.duration == pytest.approx(float(last[0].replace('.', '')) * 1e-6, rel=1e-3)
    assert table['pressure_1'][-1] == pytest.approx(1e5 + float(last[2]) * 1e5, rel=1e-3)
