"""`pneu-rig`: the rig from the command line. Loads ROS, numba and matplotlib only when needed."""

import os
import signal
import sys
import traceback
from collections.abc import Sequence

import click

from pneu_rig_ros.cli import bags, diagnosis, exchange, models, options, run
from pneu_rig_ros.errors import LONGEST_LINE, RigError, one_line

UNEXPECTED, ERROR, INTERRUPTED = 1, 2, 130
"""
Exit codes: an error of the program, or the reader of its output has gone; an error of the input;
Ctrl-C or SIGTERM.
"""

SHELLS = ('bash', 'zsh', 'fish')


@options.command(
    'eval "$(pneu-rig completion bash)"       in this shell; in ~/.bashrc for every one',
    'eval "$(pneu-rig completion zsh)"        in ~/.zshrc',
    'pneu-rig completion fish | source        in ~/.config/fish/config.fish',
)
@click.argument('shell', type=click.Choice(SHELLS))
@click.pass_context
def completion(context: click.Context, shell: str) -> None:
    """Print the script that makes a shell complete commands."""
    from click.shell_completion import get_completion_class

    script = get_completion_class(shell)
    assert script is not None, f'click knows {shell}'
    group = context.find_root().command
    click.echo(script(group, {}, 'pneu-rig', '_PNEU_RIG_COMPLETE').source())


@click.group(
    commands=[
        run.demo,
        run.simulate,
        models.sweep,
        run.replay,
        bags.info,
        bags.view,
        run.live,
        bags.friction,
        bags.repair,
        models.claims,
        models.effects,
        exchange.import_,
        exchange.export,
        bags.compare,
        diagnosis.diagnose,
        diagnosis.gap,
        completion,
    ],
    invoke_without_command=True,
    context_settings={'help_option_names': ['-h', '--help'], 'max_content_width': 99},
    epilog=options.examples(
        'pneu-rig demo                       the rig live over ROS 2, recorded and summarised',
        'pneu-rig simulate --duration 60     the same bag offline, many times faster',
        'pneu-rig sweep --u 0.3:0.6:31       strokes at 31 commands, one summary row each',
        'pneu-rig info runs/BAG              what a bag contains',
        'pneu-rig view runs/BAG              the bag as an interactive page',
        'pneu-rig live                       the running rig in the browser',
        'pneu-rig friction runs/BAG --csv f.csv',
        'pneu-rig repair runs/BAG            after a crash',
        'pneu-rig replay runs/BAG            its topics over ROS 2',
        'pneu-rig import daq.csv --map map.yaml --out runs/measured',
        'pneu-rig export runs/BAG --csv      for other programs',
        'pneu-rig compare runs/BAG --model cylinder_2',
        'pneu-rig diagnose runs/BAG... --model cylinder_2 --out answer',
        'pneu-rig gap                        a demonstration of diagnose',
        "pneu-rig claims                     the paper's statements, each measured",
        'pneu-rig effects                    the effects that the model can add',
    ),
)
@click.pass_context
def command(context: click.Context) -> None:
    """Run the emulated pneumatic servo rig and analyse its recordings, in SI units."""
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `pneu-rig`; return the exit code: 0, or one of those above."""
    previous = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        command.main(arguments, prog_name='pneu-rig', standalone_mode=False)
    except click.UsageError as error:
        path = error.ctx.command_path if error.ctx else 'pneu-rig'
        return _fail(f'{error.format_message().rstrip(".")}; see: {path} --help')
    except (click.Abort, KeyboardInterrupt):
        print('pneu-rig: interrupted', file=sys.stderr)
        return INTERRUPTED
    except (RigError, click.ClickException) as error:
        return _fail(str(error))
    except Exception as error:
        if os.environ.get('PNEU_RIG_DEBUG'):
            traceback.print_exc()
        kind = type(error).__name__
        _fail(f'unexpected {kind}: {error}; set PNEU_RIG_DEBUG=1 for the traceback')
        return UNEXPECTED
    finally:
        signal.signal(signal.SIGTERM, previous)
    return 0


def _fail(message: str) -> int:
    print(f'pneu-rig: error: {one_line(message, LONGEST_LINE)}', file=sys.stderr)
    return ERROR
