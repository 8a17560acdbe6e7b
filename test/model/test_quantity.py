"""Text of quantities: what is read and what is refused."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.model.quantity import Choice, Quantity, QuantityList

MASS = Quantity('kg', 0.0, 100.0, 'load')


@given(st.floats(0.0, 100.0))
def test_written_values_read_back_exactly(value: float) -> None:
    assert MASS.parse(MASS.format(value), 'mass') == value


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('3 g', 'mass: unit g .* allowed is kg'),
        ('101 kg', 'mass: 101 kg is not within 0 to 100 kg'),
        ('-1 kg', 'mass: -1 kg is not within'),
        ('nan kg', 'mass: nan kg is not within'),
        ('inf kg', 'mass: inf kg is not within'),
        ('three kg', "mass: 'three' is not a number"),
        (3.0, 'mass: 3.0 is not a number and its unit kg'),
        ('3', "mass: '3' is not a number and its unit kg"),
        (None, 'mass: None is not'),
    ],
)
def test_bad_text_is_refused_with_its_reason(text: object, message: str) -> None:
    with pytest.raises(RigError, match=message):
        MASS.parse(text, 'mass')


@pytest.mark.parametrize('text', ['0.5 -', '0.5', '5e-1', 0.5])
def test_pure_number_needs_no_unit(text: object) -> None:
    assert Quantity('-', 0.0, 1.0, 'share').parse(text, 'share') == 0.5


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        (2, 'share: 2 is not within 0 to 1'),
        ('0.5 kg', 'share: unit kg .* allowed is -'),
        ('half', "share: 'half' is not a number$"),
        ('-', "share: '-' is not a number$"),
        (True, 'share: True is not a number$'),
        ('', "share: '' is not a number$"),
    ],
)
def test_bad_pure_number_is_refused_with_its_reason(text: object, message: str) -> None:
    with pytest.raises(RigError, match=message):
        Quantity('-', 0.0, 1.0, 'share').parse(text, 'share')


def test_lists_name_the_entry_that_is_wrong() -> None:
    masses = QuantityList(MASS, 3)
    assert masses.parse(['1 kg', '2 kg'], 'masses') == (1.0, 2.0)
    with pytest.raises(RigError, match=r'masses\[1\]: unit g'):
        masses.parse(['1 kg', '2 g'], 'masses')
    with pytest.raises(RigError, match='at most 3'):
        masses.parse(['1 kg'] * 4, 'masses')


def test_choices_offer_the_nearest_name() -> None:
    law = Choice(('lugre', 'coulomb_viscous'), 'law')
    assert law.parse('lugre', 'model') == 0
    with pytest.raises(RigError, match="'lugr', did you mean 'lugre'"):
        law.parse('lugr', 'model')
