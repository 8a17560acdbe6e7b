"""``python -m reliability soak|faults|fuzz|numerics|scale``."""

from importlib import import_module

import click

COMMANDS = ('soak', 'faults', 'fuzz', 'numerics', 'scale')
"""Each is the function of its name in the module of its name."""


class Programs(click.Group):
    """Loads a program when it is asked for: some bring ROS along, others a cluster."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return one of them."""
        if cmd_name not in COMMANDS:
            return None
        loaded = getattr(import_module(f'reliability.{cmd_name}'), cmd_name)
        assert isinstance(loaded, click.Command)
        return loaded


@click.group(cls=Programs)
def main() -> None:
    """Prove that the suite keeps working; write docs/reliability.md and docs/reliability.json."""


if __name__ == '__main__':
    main()
