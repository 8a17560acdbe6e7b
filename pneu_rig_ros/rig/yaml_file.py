"""
YAML files, shipped or from anywhere: read without executing, expanding or guessing.

Besides invalid YAML, this refuses what a hand-written file of this project never needs and a
hostile or mistaken one may have: aliases, which can stand for terabytes; tags; the same key
twice, of which one would silently win; nesting and texts without an end.
"""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import yaml

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.quantity import unknown

LARGEST_FILE, LONGEST_TEXT, DEEPEST = 1_000_000, 1000, 20
"""Limits of a file [character], of one text in it [character], and of its nesting [level]."""

# The same parser written in C where there is one, ten times as fast.
_Base: Any = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)


class _Loader(_Base):
    """Builds plain data only, and takes no key twice."""

    def construct_mapping(self, node: Any, deep: bool = False) -> Any:
        """Return the mapping of a node."""
        found: set[object] = set()
        for key, _ in node.value:
            name = key.value if isinstance(key, yaml.ScalarNode) else None
            if name is not None and name in found:
                line = key.start_mark.line + 1
                raise yaml.constructor.ConstructorError(
                    problem=f'key {name!r} for the second time in line {line}'
                )
            found.add(name)
        return super().construct_mapping(node, deep)


def configuration_folder() -> Path:
    """
    Return the folder with the shipped configuration files.

    Beside the package in a source tree, else ``share/pneu_rig_ros/config`` of the prefix that the
    package is installed in.
    """
    package = Path(__file__).resolve().parents[1]
    if (package.parent / 'config' / 'rig.yaml').exists():
        return package.parent / 'config'
    for prefix in package.parents:
        folder = prefix / 'share' / 'pneu_rig_ros' / 'config'
        if folder.is_dir():
            return folder
    raise RigError(f'config: no share/pneu_rig_ros/config above {package}, reinstall the package')


def shipped(pattern: str) -> dict[str, Path]:
    """Return name -> path of the shipped files of a pattern below the configuration folder."""
    return {path.stem: path for path in sorted(configuration_folder().glob(pattern))}


def locate(source: str | Path, kind: str, pattern: str, more: Iterable[str] = ()) -> Path:
    """
    Return the path of a YAML file, or of a shipped one of a pattern by its name.

    :param kind: what it is called in an error, which lists ``more`` names
    :raises RigError: for a name that is not known
    """
    path, known = Path(source), shipped(pattern)
    if str(source) in known and not path.is_file():  # but maybe a folder
        return known[str(source)]
    if path.suffix in ('.yaml', '.yml') or path.exists():
        return path
    raise RigError(f'{kind}: {unknown(str(source), [*more, *known])}, or a YAML file')


def read_yaml(path: Path | str) -> dict[str, Any]:
    """Return the mapping in a YAML file; RigError when it cannot be read, or is none."""
    data = parse_yaml(read_text(path), str(path))
    if not isinstance(data, dict):
        raise RigError(f'{path}: expected a mapping of names')
    return data


def read_text(path: Path | str) -> str:
    """Return a text file in UTF-8, with or without a byte order mark; RigError if unreadable."""
    try:
        with Path(path).open(encoding='utf-8-sig') as file:
            return file.read(LARGEST_FILE + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, 'strerror', None) or error
        raise RigError(f'{path}: cannot be read: {reason}') from None


def parse_yaml(
    text: str, origin: str, largest: int = LARGEST_FILE, longest: int = LONGEST_TEXT
) -> Any:
    """
    Return the plain data of a YAML text, None if it is empty.

    :param origin: what to call the text in an error
    :raises RigError: when it is not YAML, is longer than ``largest``, or a text in it is longer
        than ``longest`` [character]
    """
    if len(text) > largest:
        raise RigError(f'{origin}: longer than {largest} characters')
    try:
        _check(text, longest)
        return yaml.load(text, _Loader)
    except (yaml.YAMLError, ValueError, OverflowError) as error:
        # invalid dates and numbers raise ValueError
        raise RigError(f'{origin}: not valid YAML: {error}') from None


def _check(text: str, longest: int) -> None:
    """Raise ValueError for what goes beyond the limits, before anything is built of it."""
    depth = 0
    for event in yaml.parse(text, Loader=_Base):
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if complaint := _complaint(event, depth, longest):
            mark: Any = event.start_mark
            raise ValueError(f'line {mark.line + 1}: {complaint}')


def _complaint(event: Any, depth: int, longest: int) -> str:
    """Return what is wrong with an event of the parser, '' if nothing."""
    if depth > DEEPEST:
        return f'more than {DEEPEST} levels deep'
    if isinstance(event, yaml.AliasEvent):
        return f'alias *{event.anchor}; write the value out'
    if getattr(event, 'tag', None):
        return f'tag {event.tag}; write a plain value'
    if isinstance(event, yaml.ScalarEvent) and len(event.value) > longest:
        return f'text of {len(event.value)} characters, allowed are {longest}'
    return ''


def to_yaml(data: Mapping[str, Any]) -> str:
    """Return a mapping as the text of a YAML file, in its order."""
    return yaml.safe_dump(dict(data), sort_keys=False)
