"""Units of laboratories against their definitions."""

import pytest

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.records.units import convert, parse_unit

INCH = 0.0254
POUND = 0.45359237
GRAVITY = 9.80665
PSI = POUND * GRAVITY / INCH**2


@pytest.mark.parametrize(
    ('text', 'si_unit', 'factor', 'gauge'),
    [
        ('bar', 'Pa', 1e5, None),
        ('bar gauge', 'Pa', 1e5, True),
        ('bar(g)', 'Pa', 1e5, True),
        ('barg', 'Pa', 1e5, True),
        ('bara', 'Pa', 1e5, False),
        ('kPa abs', 'Pa', 1e3, False),
        ('psi', 'Pa', PSI, None),
        ('psia', 'Pa', PSI, False),
        ('psig', 'Pa', PSI, True),
        ('mm', 'm', 1e-3, None),
        ('µm', 'm', 1e-6, None),
        ('inch', 'm', INCH, None),
        ('in', 'm', INCH, None),
        ('kN', 'N', 1e3, None),
        ('lbs', 'N', POUND * GRAVITY, None),
        ('lb', 'kg', POUND, None),
        ('mV', 'V', 1e-3, None),
        ('ms', 's', 1e-3, None),
        ('mm/s', 'm/s', 1e-3, None),
        ('Pa', 'Pa', 1.0, None),
    ],
)
def test_unit_is_what_its_definition_says(
    text: str, si_unit: str, factor: float, gauge: bool | None
) -> None:
    unit = parse_unit(text, si_unit, 'here')
    assert unit.factor == pytest.approx(factor, rel=1e-12)
    assert unit.gauge is gauge


def test_gauge_counts_from_the_atmosphere() -> None:
    assert convert('4 bar gauge', 'Pa', 'here', 1.01e5) == pytest.approx(5.01e5)
    assert convert('4 bar', 'Pa', 'here', 1.01e5) == pytest.approx(4e5)


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('4', r"here: '4' is not a number and its unit, such as 1.5 Pa"),
        (4.0, r'here: 4.0 is not a number and its unit'),
        ('4,5 bar', r"here: '4,5' is not a finite number"),
        ('4 foo', r"here: unit 'foo' is not known, allowed is Pa or e.g. bar"),
        ('4 kg', r"here: unit 'kg' is of another kind, allowed is Pa"),
        ('4 barg', r"here: '4 barg' is a gauge pressure, allowed are absolute ones"),
    ],
)
def test_what_is_wrong_is_said(text: object, message: str) -> None:
    with pytest.raises(RigError, match=message):
        convert(text, 'Pa', 'here')
