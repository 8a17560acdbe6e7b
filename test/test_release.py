"""What `catkin_prepare_release` and bloom take of the package: manifest, version, changelog."""

import shutil
from pathlib import Path

from catkin_pkg.changelog import get_changelog_from_path
from catkin_pkg.package import parse_package
from catkin_pkg.package_version import (
    get_forthcoming_label,
    update_changelog_sections,
    update_versions,
)

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = 'pneu_rig_ros'
VERSION = '97.98.99'


def test_manifest_has_no_warning() -> None:
    warnings: list[str] = []
    parse_package(ROOT / 'package.xml', warnings=warnings).validate(warnings=warnings)
    assert warnings == []


def test_release_takes_version_and_changes_of_the_forthcoming_section(tmp_path: Path) -> None:
    """The steps of `catkin_prepare_release`, which writes into the files."""
    for name in ('package.xml', 'setup.py', 'CHANGELOG.rst'):
        shutil.copy(ROOT / name, tmp_path / name)
    before = (tmp_path / 'CHANGELOG.rst').read_text()
    changelog = get_changelog_from_path(str(tmp_path), PACKAGE)
    label = get_forthcoming_label(changelog.rst)
    assert label == 'Forthcoming'
    update_changelog_sections(
        {PACKAGE: (str(tmp_path / 'CHANGELOG.rst'), changelog, label)}, VERSION
    )
    update_versions({str(tmp_path): parse_package(tmp_path / 'package.xml')}, VERSION)
    assert parse_package(tmp_path / 'package.xml').version == VERSION
    assert f"version='{VERSION}'," in (tmp_path / 'setup.py').read_text()
    released = get_changelog_from_path(str(tmp_path), PACKAGE)
    (changes,) = released.get_content_of_version(VERSION)
    assert f'\n{changes}'.count('\n* ') == before.count('\n* ')
