"""The compiled plant on disk: found again, never stale, and a clear word when it has no place."""

from pathlib import Path

import pytest

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model import assembly


def test_module_is_written_once_and_named_after_sources_and_effects(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))
    first = assembly._module(())
    again = assembly._module(())
    leaky = assembly._module(('chamber_leak',))
    assert first.__file__ == again.__file__ != leaky.__file__
    assert len(list((tmp_path / 'pneu_rig_ros').glob('plant_*.py'))) == 2
    assert "('chamber_leak',)" in Path(str(leaky.__file__)).read_text()


def test_a_cache_that_cannot_be_written_is_told_with_the_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / 'file').write_text('')
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'file'))
    with pytest.raises(RigError, match='set XDG_CACHE_HOME'):
        assembly._module(())
