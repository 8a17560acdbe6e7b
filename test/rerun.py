"""The command that runs a failed test again."""

import os
import re
import shlex
from collections.abc import Iterable

import pytest

GROUP = re.compile(r'@\w+$')
"""What pytest-xdist adds to the name of a test that is in a group."""
PLAIN = re.compile(r'[\w./:\[\]=+,%-]+')


def rerun_commands(
    reports: Iterable[pytest.TestReport | pytest.CollectReport],
) -> list[str]:
    """Return a line for a shell for each test, or file that is not collected, once."""
    return list(dict.fromkeys(map(rerun_command, reports)))


def rerun_command(report: pytest.TestReport | pytest.CollectReport) -> str:
    """Return the line for a shell that runs one of them."""
    target = os.environ.get('MAKE_TARGET', 'test')
    node = GROUP.sub('', report.nodeid)
    if not PLAIN.fullmatch(node):  # quoted once more, for the shell that make starts
        node = shlex.quote(node).replace('$', '$$')
    return f'make {target} ARGS={shlex.quote(node)}'
