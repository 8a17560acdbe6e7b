"""Options, arguments and checks that several commands share."""

from __future__ import annotations

import contextlib
import functools
import math
from collections.abc import Callable, Iterator
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pneu_rig_ros.cli import output
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.quantity import LARGEST_INTEGER

if TYPE_CHECKING:
    from pneu_rig_ros.rig import RigConfiguration

Function = TypeVar('Function', bound=Callable[..., Any])


def examples(*lines: str) -> str:
    """Return the examples at the end of a help text, one on each line."""
    return '\b\nExamples:\n' + ''.join(f'  {line}\n' for line in lines)


def command(
    *lines: str, after: str = '', **settings: Any
) -> Callable[[Callable[..., Any]], click.Command]:
    """Return what makes a command whose help text ends with examples, and a text after them."""
    more = f'\b\n{after}' if after else ''
    return click.command(epilog=examples(*lines) + more, **settings)


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


class NewFile(click.Path):
    """A file to write, as `new_file` demands, whose name ends in a suffix."""

    def __init__(self, suffix: str = '') -> None:
        super().__init__(path_type=Path)
        self.name = 'file'
        self._suffix = suffix

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path. RigError if it cannot be used."""
        option = param.opts[0] if param else ''
        path = new_file(Path(str(super().convert(value, param, ctx))), option)
        if not path.name.lower().endswith(self._suffix):
            raise RigError(f'{option} {path}: the name must end in {self._suffix}')
        return path


PATH = click.Path(path_type=Path)
LENGTH = Between(0.0, 86_400.0, min_open=True)


def number_option(
    name: str, kind: click.ParamType[Any], default: float, help: str, unit: str | None = None
) -> Callable[[Function], Function]:
    """Return what adds an option for a number, whose default the help text shows."""
    return click.option(
        name, type=kind, default=default, show_default=True, metavar=unit, help=help
    )


def together(*decorators: Callable[[Any], Any]) -> Callable[[Function], Function]:
    """Return what adds several options, in the order of the help text."""

    def add(function: Function) -> Function:
        for decorator in reversed(decorators):
            function = decorator(function)
        return function

    return add


json_option = output.flag('--json', 'print the result as JSON')
quiet_option = output.flag('--quiet', 'print nothing but errors')
output_options = together(json_option, quiet_option)
png_option = click.option('--png', type=NewFile('.png'), help='draw the stroke as a PNG picture')
namespace_option = click.option(
    '--namespace', default='', metavar='NAME', help='ROS namespace of the rig'
)
map_option = functools.partial(click.option, '--map', 'mapping', type=PATH, metavar='YAML')
out_directory = functools.partial(click.option, '--out', type=PATH, metavar='DIRECTORY')
out_file = functools.partial(click.option, '--out', type=NewFile())
seed_option = functools.partial(click.option, '--seed', type=Whole(0, LARGEST_INTEGER))
seconds_option = functools.partial(click.option, type=Finite(), metavar='SECOND')
cylinder_option = click.option(
    '--cylinder',
    default='cylinder_2',
    show_default=True,
    metavar='NAME|FILE',
    help='cylinder_1, cylinder_2, cylinder_3, or a YAML file of your own',
)
friction_option = click.option(
    '--friction',
    metavar='LAW',
    help='coulomb_viscous, lugre, revised_lugre or revised_lugre_dwell',
)

CONDITIONS = (
    ('--supply-pressure', 'PASCAL', 'absolute supply pressure [Pa]'),
    ('--load-mass', 'KILOGRAM', 'external load [kg]'),
    ('--initial-position', 'METRE', 'position at the start, from the cap end [m]'),
    ('--rest-time', 'SECOND', 'rest before the start [s]'),
)
"""Options, units and descriptions of the conditions of a stroke; defaults: of the cylinder."""

stroke_options = together(
    number_option(
        '--u',
        Between(-2.5, 2.5),
        0.34,
        'command of both valves by Eq. 1 [V]; positive extends the piston',
        'VOLT',
    ),
    number_option('--duration', LENGTH, 20.0, 'length of the stroke [s]', 'SECOND'),
    out_directory(help='bag to create; must not exist  [default: runs/DATE_CYLINDER]'),
    cylinder_option,
    friction_option,
    *(click.option(name, type=float, metavar=unit, help=text) for name, unit, text in CONDITIONS),
    click.option('--sensors', metavar='KIND', help="'rig' (noise, 12 bit) or 'ideal'"),
    seed_option(help='seed of the noise and the gains of the sensors'),
)
"""Options of a stroke of a configured rig."""


def workers_options(
    default: int | None = None,
    help: str = 'processes that share the work  [default: one per processor]',
) -> Callable[[Function], Function]:
    """Return what adds the options of distributed work: processes, or a cluster."""
    return together(
        click.option(
            '--workers',
            type=Whole(1, 256),
            default=default,
            show_default=default is not None,
            help=help,
        ),
        click.option(
            '--scheduler',
            metavar='ADDRESS',
            help='address of a Dask cluster to use instead, tcp://HOST:PORT',
        ),
    )


bag_argument = click.argument(
    'bag',
    type=PATH,
    # from within a bag, '.' is one with a name
    callback=lambda _, __, bag: bag.resolve() if bag.name in {'', '..'} else bag,
)


class VariadicOptionCommand(click.Command):
    """
    A command whose ``--verify`` takes all words up to the next option.

    click gives an option one word; the next one would silently become an argument.
    """

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Repeat the option before each of its paths, which is how click takes several."""
        words: list[str] = []
        option, repeated = '', '--verify'
        for index, word in enumerate(args):
            if word == '--':
                words += args[index:]
                break
            if word.startswith('-'):
                option = word.partition('=')[0]
            elif option == repeated and words[-1] != repeated:
                words.append(repeated)
            words.append(word)
        return super().parse_args(ctx, words)


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


def load_ros() -> None:
    """Import rclpy first, as it may restart this process. RigError if there is no ROS 2."""
    try:
        import pneu_rig_ros.nodes.embedding  # noqa: F401
    except ImportError as error:
        raise RigError(
            f'ROS 2 not found ({error}); source your installation, or install the package with '
            "its extra 'ros'; pneu-rig simulate needs none"
        ) from error


def bag_path(out: Path | None, name: str) -> Path:
    """Return the directory of a new bag. RigError if the one asked for exists."""
    if out is not None:
        if out.exists():
            raise RigError(f'--out {out} exists; name a directory that does not, or remove it')
        return out
    stem = f'{datetime.now():%Y-%m-%d_%H-%M-%S}_{Path(name).stem}'
    path, number = Path('runs') / stem, 2
    while path.exists():
        path, number = Path('runs') / f'{stem}_{number}', number + 1
    return path


@contextlib.contextmanager
def directory(path: Path, empty: bool = False) -> Iterator[None]:
    """
    Create a directory for the block; afterwards remove what was created and is empty.

    :param empty: whether the directory must be so, if there is one
    :raises RigError: when it cannot be used
    """
    created = []
    try:
        try:
            created = [folder for folder in (path, *path.parents) if not folder.exists()]
            path.mkdir(parents=True, exist_ok=True)
            full = empty and any(path.iterdir())
        except OSError as error:
            raise RigError(f'--out {path}: {error.strerror}; name a new directory') from error
        if full:
            raise RigError(f'--out {path} is not empty; name a new or an empty directory')
        yield
    finally:
        for folder in created:
            with contextlib.suppress(OSError):  # one that is not empty stays
                folder.rmdir()


def new_file(path: Path, option: str) -> Path:
    """Return the path of a file to write. RigError if it exists or its folder does not."""
    if str(path) == '-':
        raise RigError(f'{option} -: a file is needed, standard output is not one')
    if path.exists():
        raise RigError(f'{option} {path} exists; name a file that does not, or remove it')
    if not path.parent.is_dir():
        raise RigError(f'{option} {path}: there is no directory {path.parent}; create it first')
    return path
