"""`pneu-rig completion`: commands and options completed by the shell."""

from __future__ import annotations

import click

SHELLS = ('bash', 'zsh', 'fish')
VARIABLE = '_PNEU_RIG_COMPLETE'
"""What the printed script sets when it asks `pneu-rig` for completions."""


@click.command(
    short_help='The script that makes the shell complete commands',
    epilog='\b\nExamples:\n'
    '  eval "$(pneu-rig completion bash)"       in this shell; in ~/.bashrc, in every one\n'
    '  eval "$(pneu-rig completion zsh)"        in ~/.zshrc\n'
    '  pneu-rig completion fish | source        in ~/.config/fish/config.fish\n',
)
@click.argument('shell', type=click.Choice(SHELLS))
@click.pass_context
def completion(context: click.Context, shell: str) -> None:
    """Print what a shell runs to complete commands, options and file names of pneu-rig."""
    from click.shell_completion import get_completion_class

    script = get_completion_class(shell)
    assert script is not None, f'click knows {shell}'
    click.echo(script(context.find_root().command, {}, 'pneu-rig', VARIABLE).source())
