"""``python -m reliability soak|faults|fuzz|numerics|scale``."""

import click


@click.group()
def main() -> None:
    """Prove that the suite keeps working; write docs/reliability.md and docs/reliability.json."""


if __name__ == '__main__':
    main()
