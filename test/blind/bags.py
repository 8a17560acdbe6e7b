"""Readings as rosbag2 directories, as the recorder writes them; nothing tells the truth."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from pneu_rig_ros.records import BagWriter
from pneu_rig_ros.records.cdr_encoding import PlantMessages, pack_float64, pack_valve_voltages
from pneu_rig_ros.records.topics import TOPICS
from pneu_rig_ros.rig import Sample

from .circumstances import Stamps
from .sensors import Readings

DAC_STEP = 5.0 / 4095
CONDITIONS = ('supply_pressure', 'load_mass', 'rest_time')


def valve_voltages(u: np.ndarray) -> np.ndarray:
    """u1, u2 [V] for commands u [V], shape (n, 2): Eq. 1 in steps of the converter."""
    wanted = np.clip(np.stack([2.5 + u, 2.5 - u], axis=1), 0.0, 5.0)
    return np.round(wanted / DAC_STEP) * DAC_STEP


def write_bag(
    path: Path,
    readings: Readings,
    u: np.ndarray,
    operation: Mapping[str, float],
    atmosphere: float,
    interval_ns: int,
    pressure_variance: float,
    without: tuple[str, ...] = (),
    stamps: Stamps | None = None,
    delay_ns: int = 0,
) -> None:
    """
    Write a bag and its conditions.yaml; ``u`` has one entry fewer than the readings.

    :param without: topics of the plant that are not recorded
    :param stamps: of the readings, where they are not exact
    :param delay_ns: by which the commands are stamped later
    """
    messages = PlantMessages(pressure_variance)
    voltages = valve_voltages(u)
    with BagWriter(path) as writer:
        for k, row in enumerate(zip(*readings[1:], strict=True)):
            now = k * interval_ns if stamps is None else int(stamps.times[k])
            for topic, cdr in messages.pack(Sample(k, *map(float, row)), now).items():
                if topic not in without and (stamps is None or stamps.kept[k]):
                    writer.write(f'/{topic}', TOPICS[topic].type, now, cdr)
            now = k * interval_ns + delay_ns
            if k < len(u):
                if k == 0 or u[k] != u[k - 1]:
                    writer.write('/u', TOPICS['u'].type, now, pack_float64(float(u[k])))
                cdr = pack_valve_voltages(*map(float, voltages[k]))
                writer.write('/valve_voltages', TOPICS['valve_voltages'].type, now, cdr)
    units = {'supply_pressure': 'Pa', 'load_mass': 'kg', 'rest_time': 's'}
    lines = [f'{name}: {operation[name]!r} {units[name]}' for name in CONDITIONS]
    lines.append(f'atmospheric_pressure: {atmosphere!r} Pa')
    (path / 'conditions.yaml').write_text('\n'.join(lines) + '\n')


def write_signals(path: Path, signals: Mapping[str, np.ndarray], interval_ns: int) -> None:
    """Write a bag of a valve block: both pressures [Pa] and the voltages of both valves [V]."""
    names = 'pressure_1', 'pressure_2', 'voltage_1', 'voltage_2'
    messages = PlantMessages(0.0)
    with BagWriter(path) as writer:
        for k, row in enumerate(zip(*(signals[name] for name in names), strict=True)):
            p1, p2, *voltages = map(float, row)
            now = k * interval_ns
            packed = messages.pack(Sample(k, 0.0, 0.0, p1, p2), now)
            cdrs = {
                **{topic: packed[topic] for topic in ('chamber_1/pressure', 'chamber_2/pressure')},
                'valve_voltages': pack_valve_voltages(*voltages),
            }
            for topic, cdr in cdrs.items():
                writer.write(f'/{topic}', TOPICS[topic].type, now, cdr)
