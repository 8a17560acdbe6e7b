"""YAML files whose top is a mapping."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from pneu_rig_ros.errors import RigError


def read_yaml(path: Path | str) -> dict[str, Any]:
    """
    Return the mapping in a YAML file.

    :raises RigError: when the file cannot be read, or is something else
    """
    try:
        data = yaml.safe_load(Path(path).read_text(encoding='utf-8'))
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, 'strerror', None) or error
        raise RigError(f'{path}: cannot be read: {reason}') from None
    except yaml.YAMLError as error:
        raise RigError(f'{path}: not valid YAML: {" ".join(str(error).split())}') from None
    if not isinstance(data, dict):
        raise RigError(f'{path}: expected a mapping of names')
    return data


def to_yaml(data: Mapping[str, Any]) -> str:
    """Return a mapping as the text of a YAML file, in its order."""
    return yaml.safe_dump(dict(data), sort_keys=False)
