"""The answer of a diagnosis in words."""

import pytest

from pneu_rig_ros.report.diagnosis_rows import cut_text, number


@pytest.mark.parametrize(
    ('value', 'digits', 'text'),
    [
        (0.184, 2, '0.18'),
        (1.0, 3, '1.00'),
        (412.3, 2, '412'),
        (-1234.5, 3, '-1234'),
        (999.7, 3, '1000'),
        (9999.4, 3, '9999'),
        (9999.6, 3, '1.00e+04'),
        (26500.0, 4, '2.650e+04'),
        (2e-5, 3, '2.00e-05'),
    ],
)
def test_numbers_below_ten_thousand_have_no_exponent(value: float, digits: int, text: str) -> None:
    assert number(value, digits) == text


def test_gap_is_told_in_plain_numbers_and_what_closed_it() -> None:
    answer = {'verdict': 'effect', 'gap': {'before': 412.3, 'after': 0.184, 'cut': 0.9996}}
    text = '412 noise floors above the noise before, 0.18 after: 100% of the gap is closed'
    assert cut_text(answer) == text
    slopes = {'calibration': {'position': {}}}
    assert cut_text(answer | slopes) == text
    found = cut_text(answer | slopes | {'verdict': 'consistent'})
    assert found == text + ' by the slopes of the sensors'
