"""Options that several commands share."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pneu_rig_ros.errors import RigError

if TYPE_CHECKING:
    from pneu_rig_ros.rig import RigConfiguration

Command = TypeVar('Command', bound=Callable[..., Any])


LARGEST_SEED = 2**53
"""Up to here every integer is a number in YAML, JSON and a ROS parameter alike."""


class Finite(click.types.FloatParamType):
    """A number that is neither infinite nor 'nan'."""

    name = 'number'

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return the number that a text says."""
        number = float(super().convert(value, param, ctx))
        if not math.isfinite(number):
            self.fail(f'{value!r} is not a finite number.', param, ctx)
        return number


class Between(Finite, click.FloatRange):
    """A finite number between two, these included."""


class Whole(click.IntRange):
    """An integer between two, these included."""

    name = 'integer'


FINITE = Finite()
SEED = Whole(0, LARGEST_SEED)

_RIG_OPTIONS = (
    click.option(
        '--cylinder',
        default='cylinder_2',
        show_default=True,
        metavar='NAME|FILE',
        help='cylinder_1, cylinder_2, cylinder_3, or a YAML file of your own',
    ),
    click.option(
        '--friction',
        metavar='MODEL',
        help='coulomb_viscous, lugre, revised_lugre or revised_lugre_dwell',
    ),
    click.option('--supply-pressure', type=float, metavar='PASCAL', help='absolute [Pa]'),
    click.option('--load-mass', type=float, metavar='KILOGRAM', help='external load [kg]'),
    click.option('--initial-position', type=float, metavar='METRE', help='from the cap end [m]'),
    click.option('--rest-time', type=float, metavar='SECOND', help='rest before the start [s]'),
    click.option('--sensors', metavar='KIND', help="'rig' (noise, 12 bit) or 'ideal'"),
    click.option('--seed', type=SEED, metavar='INTEGER', help='of the sensor noise'),
)

_STROKE_OPTIONS = (
    click.option(
        '--u',
        type=float,
        default=0.34,
        show_default=True,
        metavar='VOLT',
        help='command of Eq. 1 [V], positive extends, -2.5 to 2.5',
    ),
    click.option(
        '--duration',
        type=float,
        default=20.0,
        show_default=True,
        metavar='SECOND',
        help='length of the stroke [s]',
    ),
    click.option(
        '--out',
        type=click.Path(path_type=Path),
        metavar='DIRECTORY',
        help='bag to create; must not exist  [default: runs/DATE_CYLINDER]',
    ),
)


def stroke_options(function: Command) -> Command:
    """Add the options of a stroke of a configured rig."""
    for option in reversed((*_STROKE_OPTIONS, *_RIG_OPTIONS)):
        function = option(function)
    return function


def workers_options(
    default: int | None = None,
    help: str = 'processes that share the work  [default: one for each processor]',
) -> Callable[[Command], Command]:
    """Return what adds the options of work that is shared out: processes, or a cluster."""
    workers = click.option(
        '--workers',
        type=Whole(1, 256),
        metavar='INTEGER',
        default=default,
        show_default=default is not None,
        help=help,
    )
    scheduler = click.option(
        '--scheduler',
        metavar='ADDRESS',
        help='of a Dask cluster to use instead, tcp://HOST:PORT',
    )
    return lambda function: workers(scheduler(function))


def bag_argument(function: Command) -> Command:
    """Add the argument BAG; from within a bag, '.' is one with a name."""
    named = click.argument('bag', type=click.Path(path_type=Path), callback=_named)
    return named(function)


def _named(_context: click.Context, _parameter: click.Parameter, bag: Path) -> Path:
    return bag.resolve() if bag.name in {'', '..'} else bag


def quiet_option(function: Command) -> Command:
    """Add the option --quiet: no progress and no summary; what --json prints is printed."""
    return click.option('--quiet', is_flag=True, help='print nothing but errors')(function)


def check_stroke(u: float, duration: float) -> None:
    """Raise RigError unless command [V] and duration [s] are usable."""
    if not abs(u) <= 2.5:
        raise RigError(f'--u {u:g}: must be between -2.5 and 2.5 V, where the valves saturate')
    if not 0.0 < duration <= 86_400.0:
        raise RigError(f'--duration {duration:g}: must be above 0 and at most 86400 s')


def load(cylinder: str, settings: dict[str, Any]) -> RigConfiguration:
    """Return the configuration that the options describe. RigError if there is none."""
    from pneu_rig_ros.rig import load_configuration

    try:
        return load_configuration(cylinder, **settings)
    except RigError as error:
        name, colon, rest = str(error).partition(':')
        if name not in settings:
            raise
        raise RigError(f'--{name.replace("_", "-")}{colon}{rest}') from None


def bag_path(out: Path | None, cylinder: str) -> Path:
    """Return the directory of a new bag. RigError if the one asked for exists."""
    if out is not None:
        if out.exists():
            raise RigError(f'--out {out} exists; name a directory that does not, or remove it')
        return out
    name = f'{datetime.now():%Y-%m-%d_%H-%M-%S}_{Path(cylinder).stem}'
    path, number = Path('runs') / name, 2
    while path.exists():
        path, number = Path('runs') / f'{name}_{number}', number + 1
    return path


@contextlib.contextmanager
def directory(path: Path) -> Iterator[None]:
    """
    Have a directory while the block runs; afterwards remove what was made for it and is empty.

    :raises RigError: when it cannot be made
    """
    made = []
    try:
        try:
            made = [one for one in (path, *path.parents) if not one.exists()]
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise RigError(f'--out {path}: {error.strerror}; name a new directory') from error
        yield
    finally:
        for one in made:
            with contextlib.suppress(OSError):  # what holds something stays
                one.rmdir()


def new_file(path: Path, option: str) -> Path:
    """Return the path of a file to write. RigError if it exists or its folder does not."""
    if str(path) == '-':
        raise RigError(f'{option} -: a file is needed, standard output is not one')
    if path.exists():
        raise RigError(f'{option} {path} exists; name a file that does not, or remove it')
    if not path.parent.is_dir():
        raise RigError(f'{option} {path}: there is no directory {path.parent}; create it first')
    return path


def new_picture(path: Path | None) -> Path | None:
    """Return the path of a PNG file to write, if any. RigError as new_file, or unless so named."""
    if path is None:
        return None
    if new_file(path, '--png').suffix.lower() != '.png':
        raise RigError(f'--png {path}: pictures are PNG files, so the name must end in .png')
    return path
