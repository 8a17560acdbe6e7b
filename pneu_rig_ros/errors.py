"""The error for what a user can cause and correct."""

import contextlib
from collections.abc import Iterator

LONGEST_LINE = 1000
"""Longest text of an error [character]; the middle of a longer one is omitted."""


class RigError(Exception):
    """
    Bad input or a missing prerequisite, reported in one line: what, where, allowed.

    The command line prints it and ends with exit code 2; nodes log it and stop. What it quotes
    may come from anywhere, so that it goes through :func:`one_line`.
    """

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message, LONGEST_LINE))


@contextlib.contextmanager
def prefixed(place: object) -> Iterator[None]:
    """Put a place, such as a file, before the message of a RigError that is raised within."""
    try:
        yield
    except RigError as error:
        raise RigError(f'{place}: {error}') from error


def one_line(text: str, longest: int) -> str:
    r"""
    Return a text as one line of printable characters, so that it cannot command a terminal.

    >>> one_line('a\tname\x1b[31m', 99)
    'a name\\x1b[31m'
    """
    half = longest // 2
    line = text if len(text) <= 4 * longest else f'{text[: 2 * longest]}{text[-2 * longest :]}'
    line = printable(' '.join(line.split()))
    return line if len(line) <= longest else f'{line[:half]} ... {line[-half:]}'


def printable(text: str) -> str:
    """Return a text with escapes in the place of what is not printable."""
    if text.isprintable():
        return text
    return ''.join(c if c.isprintable() else c.encode('unicode_escape').decode() for c in text)
