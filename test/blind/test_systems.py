"""The second plant's systems against closed forms, and the files that are made of them."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import yaml

from pneu_rig_ros.model.parameters import SECTIONS
from pneu_rig_ros.model.quantity import specifications
from pneu_rig_ros.records import read_recording
from pneu_rig_ros.scenarios.hidden import Secret

from . import bench, block, imposed, systems
from . import constants as at
from .along import friction_along
from .cases import make_files, visibility
from .contributions import volumes
from .files import Files
from .fresh import drawn
from .imposed import CENTRE, at_zero, gas_run, steps, waves
from .plant import Plant
from .rig import INTERVAL, runs
from .runs import Run, equations
from .sealed import SEALED, VESSEL, conductance
from .settings import Settings, changed, operation
from .system import System, stream
from .systems import SYSTEMS

KEY = 'a trial'
NOTHING = Secret({}, {}, {})
SHUT = np.full((3000, 2), CENTRE)


class Trial(NamedTuple):
    """What is hidden in a system, its recordings as they really were, and their files."""

    secret: Secret
    runs: list[Run]
    files: Files


@pytest.fixture(scope='module')
def recorded(system: System, tmp_path_factory: pytest.TempPathFactory) -> Trial:
    """Return a trial of a system, recorded once for the tests of its parametrization."""
    secret = system.hide(system.hidden[0], 1.0, systems.sizes(system, KEY))
    folder = tmp_path_factory.mktemp(system.name) / 'recordings'
    real = systems.runs(system, KEY, secret)
    return Trial(secret, real, systems.write_runs(folder, system, KEY, secret, real))


EVERY_SYSTEM = pytest.mark.parametrize('system', SYSTEMS.values(), ids=SYSTEMS, scope='module')


def chambers(**pressures: float) -> Settings:
    start = {'initial_pressure_1': 4e5, 'initial_pressure_2': 3e5, **pressures}
    return changed(systems.sizes(SEALED, KEY), operation(start))


@pytest.mark.parametrize('motion', ['waves', 'steps'])
def test_sealed_gas_is_compressed_adiabatically(motion: str) -> None:
    rig = chambers()
    stroke = rig['cylinder']['stroke']
    way = (
        waves(stroke, stream(KEY, 1)) if motion == 'waves' else steps(stroke, 60.0, stream(KEY, 1))
    )
    states = gas_run(rig, {}, way, SHUT, 0.02)
    c = Plant(rig).c
    kept = states[:, [at.P1, at.P2]] * volumes(states, c) ** c[at.KAPPA]
    assert np.ptp(states[:, at.X]) > 0.1 * stroke
    assert kept == pytest.approx(np.tile(kept[0], (len(kept), 1)), rel=5e-6)
    assert np.gradient(states[:, at.X], 0.02) == pytest.approx(states[:, at.V], abs=0.05 * stroke)


def test_gas_between_conducting_walls_is_compressed_isothermally() -> None:
    rig = chambers()
    taken_up = conductance(volumes(np.zeros((1, at.STATES)), Plant(rig).c).max(), 0.02, rig)
    walls = {f'wall_heat_transfer.conductance_{i}': taken_up for i in (1, 2)}
    states = gas_run(rig, walls, waves(rig['cylinder']['stroke'], stream(KEY, 1)), SHUT, 0.02)
    kept = states[:, [at.P1, at.P2]] * volumes(states, Plant(rig).c)
    assert kept == pytest.approx(np.tile(kept[0], (len(kept), 1)), rel=0.02)


def test_vessel_empties_exponentially_through_a_choked_leak() -> None:
    rig = changed(systems.sizes(VESSEL, KEY), operation({'initial_pressure_1': 9e5}))
    area = systems.SYSTEMS['leaking_chamber'].hide('chamber_leak', 1.5, rig).effects
    hidden = {'chamber_leak.area_1': area['chamber_leak']['area_1']}
    pressure = gas_run(rig, hidden, at_zero, SHUT[:1000], 0.1)[:, at.P1]
    k, rt = rig['gas']['heat_capacity_ratio'], 287.0 * rig['gas']['supply_temperature']
    psi = (2.0 / (k + 1.0)) ** ((k + 1.0) / (2.0 * (k - 1.0)))
    rate = k * psi * np.sqrt(k * rt) * hidden['chamber_leak.area_1']
    rate /= rig['cylinder']['cap_dead_volume']
    choked = pressure > 1.9 * 1e5
    expected = 9e5 * np.exp(-rate * 0.1 * np.arange(1001))
    assert choked.sum() > 300
    assert pressure[choked] == pytest.approx(expected[choked], rel=1e-7)


def test_warm_gas_in_a_vessel_takes_the_temperature_of_the_wall() -> None:
    rig = changed(systems.sizes(VESSEL, KEY), operation({'initial_pressure_1': 5e5}))
    hidden = {'wall_heat_transfer.conductance_1': 0.05}
    pressure = gas_run(rig, hidden, at_zero, SHUT[:1000], 0.1, 330.0)[:, at.P1]
    wall, volume = rig['gas']['supply_temperature'], rig['cylinder']['cap_dead_volume']
    heat_capacity = 5e5 * volume / 330.0 / (rig['gas']['heat_capacity_ratio'] - 1.0)
    time = 0.1 * np.arange(1001)
    temperature = wall + (330.0 - wall) * np.exp(-0.05 / heat_capacity * time)
    assert pressure == pytest.approx(5e5 * temperature / 330.0, rel=1e-8)


def test_gas_that_leaks_across_stays_in_the_cylinder() -> None:
    rig = chambers()
    hidden = {'cross_piston_leak.area': 1e-7}
    states = gas_run(rig, hidden, waves(rig['cylinder']['stroke'], stream(KEY, 1)), SHUT, 0.02)
    masses = states[:, [at.M1, at.M2]]
    assert np.ptp(masses[:, 0]) > 1e-3 * masses[0, 0]
    assert masses.sum(axis=1) == pytest.approx(np.full(len(masses), masses[0].sum()), rel=1e-10)
    energy = np.sum(states[:, [at.P1, at.P2]] * volumes(states, Plant(rig).c), axis=1)[:100]
    assert energy == pytest.approx(np.full(100, energy[0]), rel=1e-9)  # at rest at first


def test_steps_through_valves_are_short_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = changed(systems.sizes(block.BLOCK, KEY), operation({'initial_pressure_1': 1e5}))
    driven = np.stack([block.voltages(rig, stream(KEY, n)) for n in (1, 2)], axis=1)[:4000]
    hidden = {'valve_lag.time_constant': 0.01, 'spool_hysteresis.width': 0.02}
    first = gas_run(rig, hidden, at_zero, driven, 1.0 / block.RATE)
    monkeypatch.setattr(imposed, 'LONGEST_STEP', 1e-4)
    fine = gas_run(rig, hidden, at_zero, driven, 1.0 / block.RATE)
    pressures = slice(at.P1, at.P2 + 1)
    assert np.ptp(first[:, at.P1]) > 3e4
    assert first[:, pressures] == pytest.approx(fine[:, pressures], abs=5.0)


def test_seal_that_slides_has_the_friction_of_its_law() -> None:
    rig = systems.sizes(bench.BENCH, KEY)
    states = bench._states(1e-2 + 5e-3 * bench._fine(), 2e5)
    force = bench.needed(states, equations(rig, {}))
    law, area = rig['friction'], rig['cylinder']['rod_area']
    steady = law['coulomb_force'] + law['viscous_coefficient'] * 5e-3 + area * 2e5
    assert force[-1] == pytest.approx(steady, rel=1e-6)
    # Dahl's law, which the bristles follow: F = F_c (1 - exp(-k x / F_c))
    k, level, way = law['element_stiffness'][0], law['coulomb_force'], 1e-4
    index = int(np.argmin(np.abs(states[:, at.X] - 1e-2 - way)))
    bent = level * (1.0 - np.exp(-k * way / level))
    offset = law['viscous_coefficient'] * 5e-3 + area * 2e5
    assert force[index] - offset == pytest.approx(bent, rel=0.02)


def test_spring_on_the_bench_pushes_back() -> None:
    rig = systems.sizes(bench.BENCH, KEY)
    states = bench._states(1e-2 + 5e-3 * bench._fine(), 2e5)
    hidden = {'load_spring.stiffness': 50.0, 'load_spring.compression': 0.02}
    more = bench.needed(states, equations(rig, hidden)) - bench.needed(states, equations(rig, {}))
    assert more == pytest.approx(50.0 * (states[:, at.X] + 0.02))


@pytest.mark.parametrize('law', ['lugre', 'revised_lugre_dwell'])
def test_friction_along_a_motion_is_that_which_the_plant_had(law: str) -> None:
    both = {'friction.model': law}
    run = runs('cylinder_1', Secret({}, both, both), 1.0)[0]
    found = friction_along(run.states, run.sticking, run.rest, INTERVAL, *run.true)
    stiffness, viscous = run.true.stiffness[0], run.true.c[at.SIGMA_2]
    had = stiffness * run.states[:, at.Z] + viscous * run.states[:, at.V]
    slides = ~run.sticking & (run.states[:, at.V] > 2e-3)
    assert slides.sum() > 300
    assert np.median(np.abs(found - had)[slides]) < 0.05
    assert np.corrcoef(found[slides], had[slides])[0, 1] > 0.99


@pytest.mark.parametrize('system', [VESSEL], ids=[VESSEL.name], scope='module')
def test_recordings_are_the_same_whenever_they_are_made(system: System, recorded: Trial) -> None:
    first, same = recorded.runs, systems.runs(system, KEY, recorded.secret)
    other = systems.runs(system, 'another', recorded.secret)
    assert len(first) == 5
    for a, b, c in zip(first, same, other, strict=True):
        assert all(np.array_equal(a.signals[name], b.signals[name]) for name in a.signals)
        assert any(not np.array_equal(a.signals[name], c.signals[name]) for name in a.signals)


@pytest.mark.parametrize(
    ('system', 'count'),
    [
        *((system, 1) for system in SYSTEMS.values()),
        *(pytest.param(system, 3, marks=pytest.mark.long) for system in SYSTEMS.values()),
    ],
)
def test_what_is_hidden_shows(system: System, count: int) -> None:
    for name in system.hidden[:count]:
        secret = system.hide(name, 2.0, systems.sizes(system, KEY))
        assert systems.visibility(system, KEY, secret) > 3.0


@pytest.mark.parametrize(
    'system',
    [
        pytest.param(system, marks=[] if system in (VESSEL, SEALED) else [pytest.mark.long])
        for system in SYSTEMS.values()
    ],
    ids=SYSTEMS,
)
def test_nothing_does_not_show(system: System) -> None:
    assert systems.visibility(system, KEY, NOTHING) == 0.0


@EVERY_SYSTEM
def test_files_hold_what_the_sensors_showed_and_no_secret(system: System, recorded: Trial) -> None:
    secret, (run, *_), files = recorded
    assert [path.stem for path in files.fit] == ['fit_1', 'fit_2', 'fit_3']
    assert len(files.verify) == 2
    table = read_recording(files.fit[0], files.mapping)
    sensors = system.sensors(systems.sizes(system, KEY))
    assert table.interval == pytest.approx(run.interval)
    assert set(table.signals) >= set(sensors)
    for name, sensor in sensors.items():
        gap = table.signals[name] - run.signals[name]
        spread = max(sensor.deviation, 1e-12)
        assert np.std(gap) == pytest.approx(spread, rel=0.15, abs=1e-9)
        assert abs(np.mean(gap)) < 0.2 * spread + 1e-9
    for path in filter(Path.is_file, files.model.parent.rglob('*')):
        assert secret.effects.keys().isdisjoint(path.read_bytes().decode(errors='ignore').split())


@EVERY_SYSTEM
def test_model_file_has_known_sections_and_keys_with_units(
    system: System, recorded: Trial
) -> None:
    model = yaml.safe_load(recorded.files.model.read_text())
    allowed = {'name', 'sensors', 'valve', 'fixed', 'each_recording', *SECTIONS}
    assert set(model) <= allowed
    for section in set(model) & set(SECTIONS):
        if model[section] != 'shut':
            wanted = specifications(SECTIONS[section])
            for key, text in model[section].items():
                wanted[key].parse(text, key)


def test_rig_without_second_pressure_has_no_topic_of_it(tmp_path: Path) -> None:
    trial = next(t for t in drawn(3) if t.part == 'one_pressure' and t.names)
    files = make_files(tmp_path / 'bags', trial)
    table = read_recording(files.fit[0], None)
    assert 'pressure_1' in table.signals
    assert 'pressure_2' not in table.signals
    assert visibility(trial) > 0.0
