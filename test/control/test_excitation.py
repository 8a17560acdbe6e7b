"""Excitations from files: the shipped ones, units, and what is refused."""

from pathlib import Path

import pytest

from pneu_rig_ros.control.excitation import SHAPES, load_excitation
from pneu_rig_ros.errors import RigError
from pneu_rig_ros.rig.yaml_file import shipped


@pytest.mark.parametrize('name', shipped('excitations/*.yaml'))
def test_shipped_ones_load_and_move_something(name: str) -> None:
    excitation = load_excitation(name)
    levels = {excitation.level(excitation.duration * i / 1000) for i in range(1000)}
    assert len(levels) > 1
    assert excitation.name == name
    if excitation.drives == 'u':
        assert excitation.level(excitation.duration + 1.0) == 0.0
        assert all(abs(level) <= 2.5 for level in levels)
    else:
        assert excitation.level(excitation.duration + 1.0) == pytest.approx(
            excitation.level(excitation.duration - 1e-6), abs=1e-4
        )
        assert all(0.0 <= level <= 0.3 for level in levels)


def test_every_shape_is_shipped() -> None:
    shapes = {type(load_excitation(name).shape).__name__ for name in shipped('excitations/*.yaml')}
    assert shapes == {shape.__name__ for shape in SHAPES.values()}


STEP = """
drives: reference
shape: step
before: 0.02 m
after: 0.1 m
delay: 1.0 s
hold: 2.0 s
"""


def test_a_reference_is_in_metres(tmp_path: Path) -> None:
    path = tmp_path / 'go.yaml'
    path.write_text(STEP)
    excitation = load_excitation(path)
    assert (excitation.drives, excitation.level(0.5), excitation.level(9.0)) == (
        'reference',
        0.02,
        0.1,
    )


@pytest.mark.parametrize(
    ('before', 'after', 'told'),
    [
        ('after: 0.1 m', 'after: 0.1 V', "unit V in '0.1 V', allowed is m"),
        ('drives: reference', 'drives: u', 'allowed is V'),
        ('shape: step', 'shape: stop', "did you mean 'step'"),
        ('shape: step', '', 'missing shape'),
        ('drives: reference', 'drives: [u]', 'drives'),
        ('after: 0.1 m', 'after: 99 m', 'not within 0 to 10 m'),
        ('delay: 1.0 s', 'delay: soon', 'delay'),
        ('delay: 1.0 s', 'wait: 1.0 s', 'wait'),
        ('delay: 1.0 s\nhold: 2.0 s', 'delay: 0 s\nhold: 0 s', 'lasts 0 s'),
        (STEP, '- 1', 'expected a mapping'),
        (STEP, '{', 'not valid YAML'),
    ],
)
def test_what_is_wrong_is_named_in_one_line(
    tmp_path: Path, before: str, after: str, told: str
) -> None:
    path = tmp_path / 'wrong.yaml'
    path.write_text(STEP.replace(before, after))
    with pytest.raises(RigError) as caught:
        load_excitation(path)
    assert told in str(caught.value)
    assert str(path) in str(caught.value)
    assert '\n' not in str(caught.value)


def test_unknown_names_are_answered_with_the_known(tmp_path: Path) -> None:
    with pytest.raises(RigError, match="did you mean 'staircase'"):
        load_excitation('stair_case')
    with pytest.raises(RigError, match='cannot be read'):
        load_excitation(tmp_path / 'none.yaml')
