"""
Runs recorded over ROS 2, several at a time.

Each is a process of plant, excitation, valve command, friction estimator and recorder in a DDS
domain of its own, in lock step: as fast as the machine allows, and the same every time.
"""

import os
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import yaml

from pneu_rig_ros.demo import NodeProcess, Value, held_signals
from pneu_rig_ros.records.conditions import FILE_NAME, format_conditions
from pneu_rig_ros.records.whole_files import atomic_write
from pneu_rig_ros.rig import Rig, RigConfiguration, load_configuration
from pneu_rig_ros.scenarios.experiments import Experiment, profile, set_up

BYTES_PER_SECOND = 5.9e5
"""How fast a bag grows [byte per simulated second], from which progress is estimated."""
DOMAINS = 50
"""Domains that are used: 1 to this one; higher ones take ports that others may have."""
WATCH = 0.1
"""Time between two looks at the processes [s]."""


class Run(NamedTuple):
    """
    A run to be recorded.

    :param experiment: what is done
    :param cylinder: whose commands and loads these are
    :param rig: configuration file of the plant
    :param bag: directory to create
    :param seed: of the sensors' noise
    """

    experiment: Experiment
    cylinder: str
    rig: Path
    bag: Path
    seed: int

    def setup(self, rig: RigConfiguration) -> dict[str, float]:
        """Return the parameters of the plant that make the run's conditions [SI]."""
        return set_up(self.experiment, self.cylinder, rig.model.cylinder.stroke)


def record(runs: Sequence[Run], progress: Callable[[float], None]) -> None:
    """
    Record runs side by side; in any case, no node is left running.

    :param progress: callback(fraction)
    :raises RigError: when a node fails
    """
    progress(0.0)
    for rig in dict.fromkeys(run.rig for run in runs):
        Rig(load_configuration(rig)).warm_up()  # else each node would compile the plant
    nodes: list[NodeProcess] = []
    with tempfile.TemporaryDirectory(prefix='pneu_rig_') as folder:
        try:
            for index, run in enumerate(runs):
                nodes.append(_start(run, index, Path(folder)))
            total = BYTES_PER_SECOND * sum(t for run in runs for t, _ in run.experiment.timeline)
            while [node for node in nodes if not node.done()]:  # done() raises if a node failed
                progress(min(sum(map(_size, runs)) / total, 1.0))
                time.sleep(WATCH)
        finally:
            with held_signals():
                for node in nodes:
                    node.stop()
    for run in runs:
        _note_conditions(run)


def _start(run: Run, index: int, folder: Path) -> NodeProcess:
    shape = profile(run.experiment, run.cylinder)
    written = atomic_write(folder / f'{index}.yaml', yaml.safe_dump(shape, sort_keys=False))
    parameters: dict[str, Value] = {
        'use_sim_time': True,
        'plant:speed': 0.0,
        'plant:cylinder': str(run.rig.resolve()),
        'plant:seed': run.seed,
        'excitation:profile': str(written),
        'valve_command:command_timeout': 0.0,
        'recorder:output': str(run.bag.resolve()),
    }
    setup = run.setup(load_configuration(run.rig))
    parameters |= {f'plant:{name}': value for name, value in setup.items()}
    # Demonstrations that run at the same time must not share a domain.
    domain = {'ROS_DOMAIN_ID': str(1 + (16 * os.getpid() + index) % DOMAINS)}
    return NodeProcess('rig_with_excitation', parameters, folder / f'{index}.log', domain)


def _size(run: Run) -> int:
    """Return the size of the bag so far [byte]."""
    return sum(file.stat().st_size for file in run.bag.glob('*.mcap'))


def _note_conditions(run: Run) -> None:
    """Write the conditions into the bag."""
    configuration = load_configuration(run.rig)
    known = run.setup(configuration)
    del known['initial_position']
    known['atmospheric_pressure'] = configuration.model.gas.atmospheric_pressure
    atomic_write(run.bag / FILE_NAME, format_conditions(known))
