"""`pneu-rig`: the rig from the command line. Loads ROS, numba and matplotlib only when needed."""

from __future__ import annotations

import os
import signal
import sys
import traceback
from collections.abc import Sequence

import click

from pneu_rig_ros.cli.claims import claims
from pneu_rig_ros.cli.compare import compare
from pneu_rig_ros.cli.completion import completion
from pneu_rig_ros.cli.demo import demo
from pneu_rig_ros.cli.diagnose import diagnose
from pneu_rig_ros.cli.effects import effects
from pneu_rig_ros.cli.export import export
from pneu_rig_ros.cli.friction import friction
from pneu_rig_ros.cli.gap import gap
from pneu_rig_ros.cli.import_ import import_
from pneu_rig_ros.cli.info import info
from pneu_rig_ros.cli.live import live
from pneu_rig_ros.cli.repair import repair
from pneu_rig_ros.cli.replay import replay
from pneu_rig_ros.cli.simulate import simulate
from pneu_rig_ros.cli.sweep import sweep
from pneu_rig_ros.cli.view import view
from pneu_rig_ros.errors import RigError

ERROR, INTERRUPTED, UNREAD = 2, 130, 1
"""Exit codes."""


@click.group(
    invoke_without_command=True,
    context_settings={'help_option_names': ['-h', '--help'], 'max_content_width': 99},
    epilog='\b\nExamples:\n'
    '  pneu-rig demo                       the rig live over ROS 2, recorded and summarised\n'
    '  pneu-rig simulate --duration 60     the same bag offline, many times faster\n'
    '  pneu-rig sweep --u 0.3:0.6:31       many strokes, what each comes to\n'
    '  pneu-rig info runs/BAG              what a bag holds\n'
    '  pneu-rig view runs/BAG              the bag as an interactive page\n'
    '  pneu-rig live                       the running rig in the browser\n'
    '  pneu-rig friction runs/BAG --csv f.csv\n'
    '  pneu-rig repair runs/BAG            after a crash\n'
    '  pneu-rig replay runs/BAG            its topics over ROS 2 again\n'
    '  pneu-rig import daq.csv --map map.yaml --out runs/measured\n'
    '  pneu-rig export runs/BAG --csv      for other programs\n'
    '  pneu-rig compare runs/BAG --model cylinder_2\n'
    '  pneu-rig diagnose runs/BAG... --model cylinder_2 --out answer\n'
    "  pneu-rig claims                     the paper's statements, each measured\n"
    '  pneu-rig effects                    the effects that the model can add\n',
)
@click.pass_context
def command(context: click.Context) -> None:
    """Run the emulated pneumatic servo rig and look at its records. SI units throughout."""
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


for _subcommand in (
    demo,
    simulate,
    sweep,
    replay,
    info,
    view,
    live,
    friction,
    repair,
    claims,
    effects,
    import_,
    export,
    compare,
    diagnose,
    gap,
    completion,
):
    command.add_command(_subcommand)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `pneu-rig`; return the exit code: 0, 2 for an error, 130 when interrupted."""
    previous = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        return _run(arguments)
    finally:
        signal.signal(signal.SIGTERM, previous)


def _run(arguments: Sequence[str] | None) -> int:
    try:
        command.main(arguments, prog_name='pneu-rig', standalone_mode=False)
    except click.exceptions.Exit as end:
        return end.exit_code
    except click.UsageError as error:
        path = error.ctx.command_path if error.ctx else 'pneu-rig'
        return _complain(f'{error.format_message().rstrip(".")}; see: {path} --help')
    except (click.Abort, KeyboardInterrupt):
        print('pneu-rig: interrupted', file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        # The reader of our output, such as `head`, has seen enough.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return UNREAD
    except (RigError, click.ClickException) as error:
        return _complain(str(error))
    except Exception as error:
        if os.environ.get('PNEU_RIG_DEBUG'):
            traceback.print_exc()
        kind = type(error).__name__
        return _complain(f'unexpected {kind}: {error}; set PNEU_RIG_DEBUG=1 to see where')
    return 0


def _complain(message: str) -> int:
    line = ' '.join(message.split())
    print(f'pneu-rig: error: {line}', file=sys.stderr)
    return ERROR
