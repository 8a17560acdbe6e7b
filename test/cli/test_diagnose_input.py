"""Input that `diagnose` cannot use: one line that names what and where, nothing half written."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from diagnosis.parts import (
    BENCH,
    CHAMBERS,
    LEAKING,
    bench_run,
    chamber_run,
    mapping,
    system_file,
    table,
    vessel_run,
)
from numpy.typing import NDArray
from terminal import Terminal

from pneu_rig_ros.records import BagWriter
from pneu_rig_ros.records.cdr_encoding import PlantMessages
from pneu_rig_ros.records.topics import TOPICS
from pneu_rig_ros.rig import Sample, load_configuration
from pneu_rig_ros.simulate import simulate

Floats = NDArray[np.float64]
Change = Callable[[Floats], Floats]

SENSORS = """
sensors: {kind: rig, resolution: 12 bit, position_span: 0.1 m, position_class: 0 -,
          position_noise: 2e-6 m, pressure_span: 4e5 Pa, pressure_class: 0 -,
          pressure_noise: 150 Pa, velocity_cutoff: 32 Hz}
"""
SEAL = ('position', 'pressure_2', 'force')
RIG = 'cylinder_1'
STEP = 1_160_000


def refused(terminal: Terminal, *arguments: object) -> str:
    """Return the only line in which `diagnose` refuses its input."""
    line = terminal.refusal('diagnose', *arguments, '--workers', 1, '--out', 'new/answer')
    assert not (terminal.directory / 'new').exists()
    return line


def seal_refused(
    terminal: Terminal, text: str = BENCH, name: str = 'position', change: Change = np.copy
) -> str:
    """Return why two recordings of a seal are refused, a signal of the second one changed."""
    first, second = (bench_run(i, 3e5, 0.0) for i in range(2))
    second[name] = change(second[name])
    runs = [table(Path(f'run_{i}.csv'), 0.01, run) for i, run in enumerate((first, second))]
    system = system_file(Path(), text)
    return refused(terminal, *runs, '--map', mapping(Path('map.yaml'), *SEAL), '--model', system)


def vessels_refused(
    terminal: Terminal, conditions: tuple[str, str], gauge: str = 'false', end: int = 200
) -> str:
    """Return why one measurement of a vessel, given twice, is refused; up to a row the second."""
    pressure = vessel_run(0, 4e5, 0.0, 1e-8, 0.0, duration=20.0)['pressure_1']
    tables = [
        table(Path('a.csv'), 0.1, {'pressure_1': pressure}),
        table(Path('b.csv'), 0.1, {'pressure_1': pressure[:end]}),
    ]
    for path, text in zip(tables, conditions, strict=True):
        path.with_suffix('.conditions.yaml').write_text(text)
    known, model = mapping(Path('map.yaml'), 'pressure_1'), system_file(Path(), LEAKING)
    known.write_text(known.read_text().replace('unit: Pa', f'unit: Pa, gauge: {gauge}'))
    first, second = tables
    return refused(terminal, first, '--verify', second, '--map', known, '--model', model)


def rig_bag(path: Path, lost: range = range(0), unknown: range = range(0)) -> Path:
    """Write a bag of a rig that lacks messages with the position, or values in some of them."""
    random, messages = np.random.default_rng(0), PlantMessages(pressure_variance=4.0)
    with BagWriter(path) as writer:
        for k in range(1500):
            x, p1, p2 = random.normal((0.1 + 5e-5 * k, 3e5, 2e5), (1e-5, 150.0, 150.0))
            sample = Sample(k, np.nan if k in unknown else float(x), 0.0, float(p1), float(p2))
            for topic, cdr in messages.pack(sample, STEP * k).items():
                if topic != 'joint_states' or k not in lost:
                    writer.write(f'/{topic}', TOPICS[topic].type, STEP * k, cdr)
    return path


def test_recordings_without_an_open_balance(terminal: Terminal) -> None:
    position = chamber_run(0, (4.5e5, 1.1e6), (0.0, 0.0), duration=20.0)['position']
    runs = [
        table(Path(f'{name}.csv'), 0.1, {'position': position + i}) for i, name in enumerate('ab')
    ]
    known = mapping(Path('map.yaml'), 'position')
    model = system_file(Path(), CHAMBERS)
    line = refused(terminal, *runs, '--map', known, '--model', model)
    assert line == (
        'a.csv: no balance can be compared: gas_1 needs signal pressure_1; gas_2 needs signal '
        'pressure_2; force needs friction.model, friction.coulomb_force, '
        'friction.element_stiffness, cylinder.moving_mass, signal pressure_1, signal pressure_2'
    )


@pytest.mark.parametrize(
    ('name', 'end', 'change'),
    [
        ('position', '0.1', lambda x: np.minimum(x + 0.06, 0.1)),
        ('pressure_2', '500000', lambda p: np.where(np.arange(p.size) % 4, 5e5, p)),
    ],
)
def test_signal_at_the_end_of_its_span(
    terminal: Terminal, name: str, end: str, change: Change
) -> None:
    line = seal_refused(terminal, BENCH + SENSORS, name, change)
    assert line.startswith(f"run_1.csv: {name} is at the end of its sensor's span ({end}) for ")
    assert line.endswith('% of the time; record it within the span')


@pytest.mark.parametrize(
    ('name', 'gauge', 'stated', 'values'),
    [
        ('supply_pressure', 'false', ('5e5 Pa', '6e5 Pa'), '500000 and 600000 Pa'),
        ('load_mass', 'false', ('0.5 kg', '2 kg'), '0.5 and 2 kg'),
        ('rest_time', 'false', ('0 s', '60 s'), '0 and 60 s'),
        ('atmospheric_pressure', 'true', ('1e5 Pa', '9.8e4 Pa'), '100000 and 98000 Pa'),
    ],
)
def test_one_measurement_under_contradictory_conditions(
    terminal: Terminal, name: str, gauge: str, stated: tuple[str, str], values: str
) -> None:
    first, second = stated
    line = vessels_refused(terminal, (f'{name}: {first}', f'{name}: {second}'), gauge)
    assert line == (
        f'a.csv and b.csv: the same samples under different conditions ({name} {values}); '
        'omit the one with the wrong conditions'
    )


@pytest.mark.parametrize('conditions', [('', ''), ('load_mass: 1 kg', '')])
@pytest.mark.parametrize('end', [200, 150])
def test_one_measurement_under_two_names(
    terminal: Terminal, conditions: tuple[str, str], end: int
) -> None:
    line = vessels_refused(terminal, conditions, end=end)
    assert line == 'b.csv: the same samples as in a.csv; give each recording once'


def test_gauge_pressures_from_another_zero_than_stated(terminal: Terminal) -> None:
    path = table(Path('a.csv'), 0.1, vessel_run(0, 3e5, 0.0, 1e-8, 0.0, duration=20.0))
    Path('a.conditions.yaml').write_text('atmospheric_pressure: 1e5 Pa')
    known = mapping(Path('map.yaml'), 'pressure_1')
    gauge = known.read_text().replace('unit: Pa', 'unit: Pa, gauge: true')
    known.write_text(f'{gauge}atmospheric_pressure: 98 kPa\n')
    line = refused(terminal, path, '--map', known, '--model', system_file(Path(), LEAKING))
    assert line == (
        'a.csv: the gauge pressures were counted from 98000 Pa, but the conditions say '
        'atmospheric_pressure: 100000 Pa; give one of them'
    )


def test_recordings_of_contradictory_machines(terminal: Terminal) -> None:
    bags = [
        simulate(load_configuration(f'cylinder_{i}'), 0.34, 1.5, Path(f'run_{i}')) for i in (1, 2)
    ]
    assert refused(terminal, *bags, '--model', RIG) == (
        'run_2: recorded with another cylinder than run_1; '
        'diagnose recordings of one system at a time'
    )


def test_single_recording_of_a_free_piston(terminal: Terminal, bag: Path) -> None:
    assert refused(terminal, bag, '--model', 'cylinder_2') == (
        f'{bag}: only one recording of a free piston given; add another, or a held-out one with '
        '--verify'
    )


@pytest.mark.parametrize('name', SEAL)
def test_constant_signal(terminal: Terminal, name: str) -> None:
    line = seal_refused(terminal, name=name, change=lambda values: np.full(values.size, 0.25))
    assert line.startswith(f'run_1.csv: {name} is 0.25 throughout: is it connected? ')


@pytest.mark.parametrize('name', SEAL)
def test_value_that_is_not_a_number(terminal: Terminal, name: str) -> None:
    line = seal_refused(terminal, name=name, change=lambda v: np.insert(v[1:], 600, np.nan))
    assert line == f"run_1.csv: row 602, column '{name}': 'nan' is not a finite number"


def test_rows_that_are_missing(terminal: Terminal) -> None:
    runs = [table(Path(f'run_{i}.csv'), 0.01, bench_run(i, 3e5, 0.0)) for i in range(2)]
    lines = runs[1].read_text().splitlines()
    runs[1].write_text('\n'.join([*lines[:501], *lines[561:]]))
    known, model = mapping(Path('map.yaml'), *SEAL), system_file(Path(), BENCH)
    assert refused(terminal, *runs, '--map', known, '--model', model) == (
        'run_1.csv: 60 samples of position are missing in succession, from 5.00 to 5.59 s, '
        'at most 50 allowed; cut the recording there'
    )


def test_messages_that_are_missing(terminal: Terminal) -> None:
    bags = [rig_bag(Path('whole')), rig_bag(Path('gap'), lost=range(700, 800))]
    assert refused(terminal, *bags, '--model', RIG) == (
        'gap: 100 samples of joint_states are missing in succession, from 0.81 to 0.93 s, '
        'at most 22 allowed; cut the recording there'
    )


def test_messages_without_a_value(terminal: Terminal) -> None:
    bags = [rig_bag(Path('whole')), rig_bag(Path('unknown'), unknown=range(700, 800))]
    assert refused(terminal, *bags, '--model', RIG) == (
        'unknown: position is nan at sample 700, must be finite'
    )


def test_file_of_a_cylinder_that_is_too_short(terminal: Terminal) -> None:
    rig = load_configuration('cylinder_1', initial_position=0.295)
    bags = [simulate(rig, 0.0, duration, Path(f'run_{duration}')) for duration in (1.5, 2.0)]
    line = refused(terminal, *bags, '--model', 'cylinder_3')
    assert line.startswith('run_1.5: position from 0.29')
    assert line.endswith('is it in another unit, or that of cylinder_1?')
