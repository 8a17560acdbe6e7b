"""`pneu-rig gap`: hide an effect in the rig, look for it, close the gap, tell what it was."""

from __future__ import annotations

import contextlib
import importlib.util
import math
import secrets
import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from pneu_rig_ros.cli import options, output
from pneu_rig_ros.cli.diagnose import write_files
from pneu_rig_ros.errors import RigError

if TYPE_CHECKING:
    from pneu_rig_ros.analysis.metrics import AnalysedRun, SignalGap
    from pneu_rig_ros.rig import RigConfiguration
    from pneu_rig_ros.scenarios.demonstration import HiddenEffect

Tell = Callable[[str, float], None]
RECORDED, DIAGNOSED, AGAIN = 0.2, 0.85, 0.97
"""Shares of the work that are done after each step [-]."""
SEEDS = 1000
"""A seed that is not given is below this number."""
NOISE_SEED = 1000
"""Of the sensors' noise in the first run; each run has its own."""


class Outcome(NamedTuple):
    """What the demonstration found: diagnosis.json, and the gap of each signal before, after."""

    answer: dict[str, Any]
    gaps: tuple[dict[str, SignalGap], dict[str, SignalGap]]


@click.command(
    short_help='Hide an effect in the rig, find it, close the gap',
    epilog='\b\nExamples:\n'
    '  pneu-rig gap\n'
    '  pneu-rig gap --seed 7 --out runs/seven\n'
    '  pneu-rig gap --effect inclination\n',
)
@click.option(
    '--seed', type=options.SEED, metavar='INTEGER',
    help='draws the effect and the noise  [default: another one each time]',
)  # fmt: skip
@click.option(
    '--out', type=click.Path(path_type=Path), metavar='DIRECTORY',
    help='directory to create  [default: runs/DATE_gap]',
)  # fmt: skip
@click.option(
    '--effect',
    metavar='NAME',
    help='hide this one of pneu-rig effects  [default: drawn from the seed]',
)
@click.option('--json', 'as_json', is_flag=True, help='print plain data for scripts')
@click.option('--quiet', is_flag=True, help='print nothing but errors')
def gap(
    seed: int | None, out: Path | None, effect: str | None, as_json: bool, quiet: bool
) -> None:
    """
    Hide an effect in the rig, find it, close the gap.

    Draws an effect and hides it in the plant, records experiments over ROS 2 into bags, diagnoses
    them with the plain model, restarts the plant with the improved one and records once more what
    no fit has seen. Ends with a picture, the gap in numbers, and what was hidden.

    Drawn is one of 14 of the 25 effects: those that show well above the noise in runs as short as
    these. --effect hides others too.
    """
    from pneu_rig_ros.scenarios.demonstration import draw

    if importlib.util.find_spec('rclpy') is None:
        raise RigError("ROS 2 is not to be found; source yours, or install the extra 'ros'")
    seed = secrets.randbelow(SEEDS) if seed is None else seed
    secret = draw(seed, effect)
    path = options.bag_path(out, 'gap')
    if not (as_json or quiet):
        _introduce(secret, seed)
    with _whole(path) as folder, output.stage_bar(quiet=quiet) as tell:
        outcome = play(folder, secret, seed, tell)
    if as_json:
        output.print_json(_plain(outcome, secret, seed, path))
    elif not quiet:
        show(outcome, secret, path)


@contextlib.contextmanager
def _whole(path: Path) -> Iterator[Path]:
    """Yield a directory to work in that becomes `path` if all goes well, else vanishes."""
    unfinished = path.with_name(f'.{path.name}.unfinished')
    shutil.rmtree(unfinished, ignore_errors=True)
    try:
        with options.directory(path.parent):
            try:
                unfinished.mkdir()
                yield unfinished
                unfinished.rename(path)
            finally:
                shutil.rmtree(unfinished, ignore_errors=True)
    except OSError as error:
        raise RigError(f'--out {path}: {error.strerror}') from error


def play(folder: Path, secret: HiddenEffect, seed: int, tell: Tell) -> Outcome:
    """
    Record, diagnose, record again, draw.

    :param folder: gets all files
    :param tell: told what is done now, and the share of the work done [-]
    :raises RigError: when a node fails
    """
    from pneu_rig_ros.demo import prepare_environment
    from pneu_rig_ros.records.atomic_write import atomic_write
    from pneu_rig_ros.scenarios.demonstration import CYLINDER
    from pneu_rig_ros.scenarios.experiments import FIT, NAMES, VERIFY
    from pneu_rig_ros.scenarios.recording import Run, record

    prepare_environment()
    model = atomic_write(folder / 'model.yaml', secret.model.to_yaml())
    truth = atomic_write(folder / 'hidden.yaml', secret.truth.to_yaml())
    measured = [
        Run(one, CYLINDER, truth, folder / 'measured' / name, _noise_seed(seed, index))
        for index, (name, one) in enumerate(zip(NAMES, (*FIT, *VERIFY), strict=True))
    ]
    title = f'recording {len(measured)} runs over ROS 2'
    record(measured, lambda share: tell(title, RECORDED * share))
    fit, verify = measured[: len(FIT)], measured[len(FIT) :]
    answer = _diagnose([r.bag for r in fit], [r.bag for r in verify], model, folder / 'answer',
                       seed, tell)  # fmt: skip
    again = [
        Run(VERIFY[0], CYLINDER, rig, folder / name / verify[0].bag.name,
            _noise_seed(seed, -index))
        for index, (name, rig) in enumerate(
            (('before', model), ('after', folder / 'answer' / 'improved.yaml')), start=1
        )
    ]  # fmt: skip
    title = 'recording again with the model before and after'
    record(again, lambda share: tell(title, DIAGNOSED + (AGAIN - DIAGNOSED) * share))
    tell('drawing', AGAIN)
    bags = [run.bag for run in again]
    return Outcome(answer, _draw(folder / 'gap.png', verify[0].bag, bags, model))


def _noise_seed(seed: int, run: int) -> int:
    """Return the seed of the sensors' noise in a run."""
    return (NOISE_SEED * (seed + 1) + run) % options.LARGEST_SEED


def _diagnose(
    fit: list[Path], verify: list[Path], model: Path, out: Path, seed: int, tell: Tell
) -> dict[str, Any]:
    """Diagnose the bags; return diagnosis.json."""
    from pneu_rig_ros.diagnosis.result import answer
    from pneu_rig_ros.diagnosis.workflow import diagnose
    from pneu_rig_ros.executor import open_executor

    def within(text: str, share: float) -> None:
        tell(f'diagnosing - {text}', RECORDED + (DIAGNOSED - RECORDED) * share)

    out.mkdir()
    with open_executor(None) as processes:
        diagnosis = diagnose(fit, model, verify, seed=seed, executor=processes, progress=within)
    data = answer(diagnosis)
    write_files(out, diagnosis, data, lambda share: within('drawing the report', 0.96))
    return data


def _draw(
    path: Path, measured: Path, models: list[Path], model: Path
) -> tuple[dict[str, SignalGap], dict[str, SignalGap]]:
    """Draw the runs; return the gaps of the model before and after."""
    from pneu_rig_ros.analysis.friction import ForceBalance
    from pneu_rig_ros.analysis.metrics import compare_signals, signal_noise
    from pneu_rig_ros.report.gap_figure import draw_gap
    from pneu_rig_ros.rig import load_configuration
    from pneu_rig_ros.rig.sensors import sensor_noise
    from pneu_rig_ros.scenarios.demonstration import CYLINDER
    from pneu_rig_ros.scenarios.experiments import VERIFY, set_up

    stroke = load_configuration(model).model.cylinder.stroke
    rig = load_configuration(model, **set_up(VERIFY[0], CYLINDER, stroke))
    truth, before, after = _runs((measured, *models), rig)
    interval, balance = truth.recording.interval, ForceBalance.of(rig)
    single = signal_noise(*sensor_noise(rig.sensors), interval, balance)
    # All runs went through the sensors: their differences have the noise of two.
    noise = {name: math.sqrt(2.0) * value for name, value in single.items()}
    gaps = (
        compare_signals(truth.signals, before.signals, noise),
        compare_signals(truth.signals, after.signals, noise),
    )
    title = 'A run that no fit has seen: the rig, its model before and after the diagnosis'
    draw_gap(path, title, truth, (before, after), gaps)
    return gaps


def _runs(bags: Sequence[Path], rig: RigConfiguration) -> list[AnalysedRun]:
    """Return the runs in bags as those of a rig, cut to the length of the shortest."""
    from pneu_rig_ros.analysis.metrics import analyse_run
    from pneu_rig_ros.records import read_recording

    recordings = [read_recording(bag) for bag in bags]
    size = min(recording.size for recording in recordings)
    return [analyse_run(replace(one.cut(0, size), configuration=rig)) for one in recordings]


SHRUNK = ('signal', '>before', '>after', '>noise of two runs', 'unit', '>gap closed')
"""Heads of the table that is printed; '>' is for numbers."""

CLEAR = 1.5
"""RMSE in noises from which the share of it that is above the noise is known to some percent."""


def _introduce(secret: HiddenEffect, seed: int) -> None:
    from pneu_rig_ros.scenarios.demonstration import DRAWN

    output.print_values({
        'rig': f'{secret.model.name}, with an effect hidden in it that its model lacks',
        'drawn from': f'{len(DRAWN)} effects, seed {seed}',
        'sensors': 'noise and 12 bit as on the rig, but no errors of gain (accuracy class 0):\n'
        f'{"":<{output.NAME_WIDTH}}these would be fitted along with what is missing',
    })  # fmt: skip


def _plain(outcome: Outcome, secret: HiddenEffect, seed: int, path: Path) -> dict[str, Any]:
    before, after = outcome.gaps
    gaps = {
        name: {'before': one.rmse, 'after': after[name].rmse, 'noise': one.noise,
               'unit': one.unit}
        for name, one in before.items()
    }  # fmt: skip
    return {'seed': seed, 'hidden': secret.effect, 'gap': gaps, 'directory': str(path),
            'diagnosis': outcome.answer}  # fmt: skip


def show(outcome: Outcome, secret: HiddenEffect, path: Path) -> None:
    """Print what was found, the gap, the files, and what was hidden."""
    from pneu_rig_ros.report import diagnosis_rows as rows

    terminal = output.console()
    terminal.print()
    terminal.print(outcome.answer['sentence'], style='bold')
    terminal.print()
    terminal.print('RMSE on the run that no fit has seen, recorded again with either model')
    output.print_table(output.table(SHRUNK, _shrunk(outcome)))
    terminal.print()
    output.print_values({
        'diagnosis': rows.cut_text(outcome.answer),
        'report': str(path / 'answer' / 'report.html'),
        'improved model': str(path / 'answer' / 'improved.yaml'),
        'bags': str(path / 'measured'),
        'picture': str(path / 'gap.png'),
    })  # fmt: skip
    terminal.print()
    output.print_values(_revelation(outcome, secret))


def _shrunk(outcome: Outcome) -> Iterator[tuple[str, ...]]:
    """Yield the rows of the table."""
    from pneu_rig_ros.report.diagnosis_rows import UNITS, number

    before, after = outcome.gaps
    for name, one in before.items():
        unit, scale = UNITS.get(one.unit, (one.unit, 1.0))
        values = [one.rmse, after[name].rmse, one.noise or 0.0]
        texts = (number(scale * value) for value in values)
        yield name.replace('_', ' '), *texts, unit, _closed(one, after[name])


def _closed(before: SignalGap, after: SignalGap) -> str:
    """Return the share of what was above the noise that is gone, if it stood out of the noise."""
    if before.noise is not None and before.rmse <= CLEAR * before.noise:
        return 'near noise'
    return f'{1.0 - after.above_noise / before.above_noise:.0%}'


def _revelation(outcome: Outcome, secret: HiddenEffect) -> dict[str, str]:
    from pneu_rig_ros.report import diagnosis_rows as rows

    found = [
        f'{row.name} {row.value} {row.unit}'.strip() for row in rows.added_rows(outcome.answer)
    ]
    return {
        'hidden was': f'{secret.effect}: {secret.text}',
        'found was': '; '.join(found) or 'nothing',
    }
