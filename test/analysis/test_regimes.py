"""The regimes seen by the rig's sensors are those of the plant's true states, on varied runs."""

from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from time import process_time

import numpy as np
import pytest
from numpy.typing import NDArray

from pneu_rig_ros.analysis.friction import ForceBalance, friction_zero_phase
from pneu_rig_ros.analysis.motion import Cycle, cycles_of, find_cycles
from pneu_rig_ros.analysis.regimes import Regimes, regimes, regimes_of
from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.effect import Regime
from pneu_rig_ros.model.plant import Plant, Trajectory
from pneu_rig_ros.records import read_recording
from pneu_rig_ros.rig import RigConfiguration, load_configuration
from pneu_rig_ros.rig.sensors import SensorSet
from pneu_rig_ros.rig.valve_drive import valve_voltages
from pneu_rig_ros.simulate import simulate

from .true_regimes import Truth, true_cycles, true_regimes

INTERVAL = 1.16e-3
LAWS = ('revised_lugre_dwell', 'revised_lugre', 'revised_lugre_dwell', 'revised_lugre', 'lugre')
NAMES = [regime.label for regime in Regime]
PEAKS = ('friction_force', 'deflection')
"""States of the plant that have their peak at breakaway."""


@dataclass(frozen=True)
class Measured:
    """A run as the plant knows it and as the rig's sensors see it."""

    configuration: RigConfiguration
    u: float
    run: Trajectory
    readings: Floats

    def regimes(self) -> Regimes:
        x, _, p1, p2 = np.ascontiguousarray(self.readings.T)
        balance = ForceBalance.of(self.configuration)
        friction = friction_zero_phase(x, p1, p2, INTERVAL, balance)
        stroke = self.configuration.model.cylinder.stroke
        return regimes(x, INTERVAL, stroke, friction, balance.pressure_force(p1, p2))

    def cycles(self) -> list[Cycle]:
        return find_cycles(self.readings[:, 0], INTERVAL)

    def truth(self, peak: str) -> Truth:
        return true_regimes(self.run, getattr(self.run, peak))

    def confusion(self, peak: str) -> NDArray[np.int64]:
        """Return how many samples of each true regime (row) are seen as each (column)."""
        table = np.zeros((len(Regime), len(Regime)), dtype=np.int64)
        np.add.at(table, (self.truth(peak).regime, self.regimes()), 1)
        return table


def measure(configuration: RigConfiguration, *commands: tuple[float, float]) -> Measured:
    """Run the plant through (u, duration) and read its sensors."""
    model = configuration.model
    volts = [np.tile(valve_voltages(u), (round(time / INTERVAL), 1)) for u, time in commands]
    run = Plant(model, configuration.effects).run(np.concatenate(volts), INTERVAL)
    sensors = SensorSet(
        configuration.sensors, model.gas.atmospheric_pressure, INTERVAL, configuration.seed
    )
    states = np.stack([run.position, run.velocity, run.pressure_1, run.pressure_2], axis=1)
    return Measured(
        configuration, commands[0][0], run, np.array([sensors.read(*s) for s in states.tolist()])
    )


def varied(index: int) -> Measured:
    """Return a run whose conditions are drawn at random, 60 % of them in stick-slip's range."""
    rng = np.random.default_rng([2024, index])
    cylinder = f'cylinder_{1 + index % 3}'
    stroke = load_configuration(cylinder).model.cylinder.stroke
    start = rng.choice([0.0, rng.uniform(0.0, 0.5)]) * stroke
    u = rng.uniform(*((0.26, 0.36) if rng.random() < 0.6 else (0.36, 0.6)))
    retracts = rng.random() < 0.4
    configuration = load_configuration(
        cylinder,
        friction=LAWS[index // 3 % len(LAWS)],
        supply_pressure=rng.uniform(4e5, 8e5),
        load_mass=rng.uniform(0.0, 5.3),
        initial_position=stroke - start if retracts else start,
        seed=index,
    )
    return measure(configuration, (-u if retracts else u, 25.0))


pytestmark = pytest.mark.xdist_group('regimes')  # the runs are measured once


@pytest.fixture(scope='module')
def runs() -> list[Measured]:
    return [varied(index) for index in range(30)]


def agreement(table: NDArray[np.int64]) -> float:
    return float(np.trace(table) / table.sum())


def test_runs_are_varied(runs: list[Measured]) -> None:
    slips = [run.truth('friction_force').slips for run in runs]
    assert sum(count >= 5 for count in slips) >= 8, 'stick-slip'
    assert sum(count <= 1 for count in slips) >= 8, 'smooth'
    assert sum(run.u < 0 for run in runs) >= 8, 'retracting'
    assert sum(bool((run.run.contact == side).any()) for run in runs for side in (-1, 1)) >= 8


@pytest.mark.parametrize('peak', PEAKS)
def test_regimes_are_the_true_ones_in_95_percent_of_samples(
    runs: list[Measured], peak: str
) -> None:
    table = np.sum([run.confusion(peak) for run in runs], axis=0)
    print(f'\n{peak}: {agreement(table):.4f}', *zip(NAMES, table.tolist(), strict=True), sep='\n')
    assert agreement(table) >= 0.95
    assert agreement(table[: Regime.END_STOP]) >= 0.95, 'without the end stops: nothing happens'


def test_regimes_are_the_true_ones_where_slip_follows_slip(runs: list[Measured]) -> None:
    rough = [run for run in runs if run.truth('friction_force').slips >= 5]
    assert len(rough) >= 10
    table = np.sum([run.confusion('friction_force')[: Regime.END_STOP] for run in rough], axis=0)
    assert agreement(table) >= 0.93


@pytest.mark.parametrize('cylinder', ['cylinder_1', 'cylinder_2', 'cylinder_3'])
def test_regimes_are_the_true_ones_for_every_cylinder(runs: list[Measured], cylinder: str) -> None:
    of_it = [run for run in runs if run.configuration.name == cylinder]
    table = np.sum([run.confusion('friction_force')[: Regime.END_STOP] for run in of_it], axis=0)
    assert agreement(table) >= 0.94


def test_no_regime_is_lost_in_the_average(runs: list[Measured]) -> None:
    table = np.sum([run.confusion('friction_force') for run in runs], axis=0)
    seen, right = table.sum(axis=0), np.diag(table)
    recall, precision = right / table.sum(axis=1), right / seen
    # presliding and breakaway last 12 and 23 ms a cycle, the shortest line fit 46 ms
    least = {
        'DWELL': (0.93, 0.95),
        'PRESLIDING': (0.4, 0.25),
        'BREAKAWAY': (0.55, 0.5),
        'SLIDING': (0.97, 0.95),
        'END_STOP': (0.97, 0.95),
    }
    for name, (found, correct) in least.items():
        assert recall[Regime[name]] >= found, name
        assert precision[Regime[name]] >= correct, name


def test_cycles_are_those_of_the_truth(runs: list[Measured]) -> None:
    counts = [(len(run.cycles()), len(true_cycles(run.run))) for run in runs]
    assert sum(seen == true for seen, true in counts) >= 0.8 * len(counts), counts
    for run, (seen, _) in zip(runs, counts, strict=True):
        # the sensor's noise of 0.4 mm/s decides of a piston that comes close to 1 mm/s
        near = [len(true_cycles(run.run, speed)) for speed in (0.6e-3, 1e-3, 1.4e-3)]
        assert min(near) - 1 <= seen <= max(near) + 1, (seen, near)


def test_dwells_are_those_of_the_truth(runs: list[Measured]) -> None:
    pairs = [([c.dwell for c in run.cycles()], true_cycles(run.run)) for run in runs]
    matched = [pair for pair in pairs if len(pair[0]) == len(pair[1]) > 3]
    assert len(matched) >= 5
    seen, true = (np.concatenate(each) for each in zip(*matched, strict=True))
    assert np.median(np.abs(seen - true)) < 0.05
    assert abs(np.mean(seen) / np.mean(true) - 1.0) < 0.05


def test_bristles_wind_up_until_breakaway_and_let_go_in_it(runs: list[Measured]) -> None:
    regime = np.concatenate([run.regimes() for run in runs])
    winds = np.concatenate([np.gradient(np.abs(run.run.deflection)) > 0 for run in runs])
    assert winds[regime == Regime.DWELL].mean() > 0.75
    assert winds[regime == Regime.BREAKAWAY].mean() < 0.2


def test_regimes_come_in_the_order_of_a_cycle(runs: list[Measured]) -> None:
    allowed = {
        Regime.DWELL: {Regime.PRESLIDING, Regime.BREAKAWAY, Regime.SLIDING, Regime.END_STOP},
        Regime.PRESLIDING: {Regime.BREAKAWAY, Regime.SLIDING},
        Regime.BREAKAWAY: {Regime.SLIDING},
        Regime.SLIDING: {Regime.DWELL, Regime.END_STOP},
    }
    for run in runs:
        regime = run.regimes()
        for before, after in pairwise(regime):
            if before != after and before != Regime.END_STOP:
                assert Regime(after) in allowed[Regime(before)]


def test_out_and_back_meets_both_stops() -> None:
    configuration = load_configuration('cylinder_1', friction='revised_lugre')
    back_and_forth = measure(configuration, (0.5, 15.0), (-0.5, 15.0), (0.0, 2.0))
    assert set(back_and_forth.run.contact.tolist()) == {-1, 0, 1}
    assert agreement(back_and_forth.confusion('friction_force')) >= 0.95
    held = back_and_forth.regimes() == Regime.END_STOP
    contact = back_and_forth.run.contact
    assert np.mean(held == (contact != 0)) > 0.99


def test_resting_piston_sticks_or_is_held() -> None:
    configuration = load_configuration('cylinder_2', initial_position=0.0)
    at_rest, pushed_in = measure(configuration, (0.0, 2.0)), measure(configuration, (-0.5, 2.0))
    assert np.all(at_rest.regimes() == Regime.DWELL)
    assert np.mean(pushed_in.regimes() == Regime.END_STOP) > 0.9
    assert at_rest.cycles() == pushed_in.cycles() == []


def test_regimes_of_a_bag_slide_after_each_breakaway(tmp_path: Path) -> None:
    bag = simulate(load_configuration('cylinder_2'), 0.34, 9.0, tmp_path / 'bag')
    record = read_recording(bag)
    found, cycles = regimes_of(record), cycles_of(record)
    assert found.shape == record.position.shape
    assert len(cycles) >= 3
    for cycle in cycles:  # it creeps off for 0.3 s before it slips
        onset = round(cycle.breakaway_time / record.interval)
        assert Regime.SLIDING in found[onset : onset + round(0.6 / record.interval)]
    with pytest.raises(RigError, match='rig_description'):
        regimes_of(replace(record, configuration=None))


def test_a_record_of_25_seconds_takes_less_than_50_milliseconds(runs: list[Measured]) -> None:
    runs[0].regimes()
    times = []
    for _ in range(5):
        begin = process_time()
        runs[0].regimes()
        times.append(process_time() - begin)
    assert min(times) < 0.05


def test_strokes_of_different_speed_have_feeds_of_their_own() -> None:
    # 200 mm/s out, at rest, 10 mm/s back: half of the mean speed would call the way back a dwell
    time = np.arange(0.0, 25.0, INTERVAL)
    position = np.interp(
        time, [0.0, 1.0, 2.0, 4.0, 22.0, 25.0], [0.05, 0.05, 0.25, 0.25, 0.07, 0.07]
    )
    read = 73e-6 * np.round(
        (position + np.random.default_rng(0).normal(0.0, 2e-5, time.size)) / 73e-6
    )
    nothing = np.zeros_like(read)
    found = regimes(read, INTERVAL, 0.3, friction=nothing, push=nothing)
    assert (found[(time > 4.3) & (time < 21.7)] == Regime.SLIDING).all()
    assert (found[(time > 2.2) & (time < 3.8)] == Regime.DWELL).all()
