"""
The text on the topic `rig_description` and the custom data of a bag.

The text is the configuration's YAML, headed by a comment with package version and git revision.
The custom data follow from the text, so that a bag whose end is missing gets them back from the
recorded message.
"""

import functools
import re
import subprocess
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.rig import RigConfiguration, configuration_from_yaml
from pneu_rig_ros.rig.yaml_file import parse_yaml

UNKNOWN = 'unknown'
_HEAD = '# pneu_rig_ros {version}, git revision {revision}\n'
_HEAD_PATTERN = re.compile(r'# pneu_rig_ros (?P<version>\S+), git revision (?P<revision>\S+)')


def describe(configuration: RigConfiguration) -> str:
    """Return the text of `rig_description`: complete YAML that loads back unchanged."""
    head = _HEAD.format(version=package_version(), revision=git_revision())
    return head + configuration.to_yaml()


def bag_metadata(description: str) -> dict[str, str]:
    """
    Return the custom data of a bag from the text of `rig_description`.

    Keys: configuration, cylinder, friction_model, seed, package_version, git_revision; 'unknown'
    for an entry that the text lacks.
    """
    head = _HEAD_PATTERN.match(description)
    try:
        sections = parse_yaml(description, 'rig_description')
    except RigError:
        sections = None
    return {
        'configuration': description,
        'cylinder': _entry(sections, 'name'),
        'friction_model': _entry(sections, 'friction', 'model'),
        'seed': _entry(sections, 'sampling', 'seed').removesuffix(' -'),
        'package_version': head['version'] if head else UNKNOWN,
        'git_revision': head['revision'] if head else UNKNOWN,
    }


def configuration_in(custom: Mapping[str, str]) -> RigConfiguration | None:
    """Return the rig that the custom data of a bag describe, None where they do not."""
    text = custom.get('configuration')
    return configuration_from_yaml(text, 'configuration') if text else None


def _entry(sections: object, *keys: str) -> str:
    for key in keys:
        sections = sections.get(key, UNKNOWN) if isinstance(sections, dict) else UNKNOWN
    return str(sections)


@functools.cache
def package_version() -> str:
    """Return the version of the installed package, 'unknown' in a bare source tree."""
    try:
        return metadata.version('pneu_rig_ros')
    except metadata.PackageNotFoundError:
        return UNKNOWN


@functools.cache
def git_revision() -> str:
    """Return the commit of the source tree, '-modified' if it differs; 'unknown' outside git."""
    package = Path(__file__).resolve().parents[1]
    command = ['git', '-C', str(package.parent)]
    try:
        top = _output([*command, 'rev-parse', '--show-toplevel'])
        if Path(top) != package.parent:
            return UNKNOWN
        return _output([*command, 'describe', '--always', '--dirty=-modified', '--exclude=*'])
    except (OSError, subprocess.SubprocessError):
        return UNKNOWN


def _output(command: list[str]) -> str:
    run = subprocess.run(command, capture_output=True, text=True, check=True, timeout=5.0)
    return run.stdout.strip()
