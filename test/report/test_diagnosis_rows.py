"""The answer of a diagnosis in words."""

import pytest

from pneu_rig_ros.report.diagnosis_rows import (
    balance_rows,
    cut_text,
    each_rows,
    gap_rows,
    next_lines,
    note_lines,
    number,
    ranking,
    where_rows,
)


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
    answer = {
        'verdict': 'effect',
        'gap': {'of': 'residuals', 'before': 412.3, 'after': 0.184, 'cut': 0.9996},
    }
    text = 'excess over the noise 412 before, 0.18 after: 100% of the gap is closed'
    assert cut_text(answer) == text
    found = cut_text(answer | {'verdict': 'uncalibrated'})
    assert found == text + ' by the gains of the sensors'
    agrees = {
        'verdict': 'consistent',
        'gap': {'of': 'residuals', 'before': 0.0, 'after': 0.0, 'cut': None},
    }
    assert cut_text(agrees) == 'no residual exceeds the noise'


def test_disagreement_is_told_with_its_place() -> None:
    one = {
        'balance': 'gas_1',
        'regime': 'sliding',
        'direction': 'out',
        'unit': 'kg/s',
        'mean': 2.5e-6,
        'noise': 1e-7,
        'significance': 25.0,
        'p_value': 0.0,
        'variable': 'position',
        'from': 0.02,
        'to': 0.035,
        'recordings': ['a'],
        'intervals': [{'recording': 'a', 'from': 1.0, 'to': 2.5}],
    }
    (row,) = where_rows({'where': [one]})
    assert row == (
        'gas_1',
        'sliding out',
        'x 20.0 to 35.0 mm',
        '2.50',
        '0.100',
        'mg/s',
        '25.0',
        'a, 1.00-2.50 s',
    )
    (row,) = where_rows({'where': [one | {'variable': '', 'from': None, 'intervals': []}]})
    assert (row[2], row[-1]) == ('all', '-')
    (row,) = where_rows({'where': [one | {'variable': 'dwell', 'from': 0.46, 'to': 4.79}]})
    assert row[2] == 'dwell 0.460 to 4.79 s'


def test_closed_balance_tells_what_is_missing() -> None:
    closed = {'name': 'gas_2', 'open': False, 'why': 'signal u, valve.a, valve.b', 'left': None}
    opened = {'name': 'force', 'open': True, 'why': '', 'verdict': 'effect', 'left': 0.031}
    other = {**opened, 'verdict': 'unknown'}
    answer = {'verdict': 'effect', 'balances': [closed, opened, other]}
    assert balance_rows(answer, most=1)[0][1] == 'closed: no signal u and 2 more'
    assert balance_rows(answer)[0][1] == 'closed: no signal u, valve.a, valve.b'
    assert balance_rows(answer)[1] == ('force', 'disagrees', '3%')
    assert balance_rows(answer)[2] == ('force', 'disagrees: unknown', '3%')


def test_signals_of_a_simulation_that_broke_down_have_no_number() -> None:
    signal = {'unit': 'Pa', 'noise': 150.0, 'before': None, 'after': 300.0}
    (row,) = gap_rows({'gap': {'signals': {'pressure_1': signal}}})
    assert row == ('pressure 1', '-', '0.300', '0.150', 'kPa', '-', '2.0')


def test_offset_of_a_clock_has_an_interval_and_a_p_value() -> None:
    late = {
        'recording': 'a',
        'name': 'clock_offset',
        'value': 0.21,
        'interval': [0.18, 0.24],
        'p_value': 1e-40,
        'unit': 's',
    }
    near = late | {'value': 1.93e-5, 'interval': [-2.46e-4, 2.84e-4], 'p_value': 0.8864}
    rows = each_rows({'each_recording': [late, near]})
    assert rows[0] == ('a', 'clock offset', '0.210', '0.180 to 0.240', 's', '< 0.001')
    assert rows[1][2:] == ('0.00002', '-0.00025 to 0.00028', 's', '0.886')


def test_recordings_with_the_same_note_share_a_line() -> None:
    notes = [{'recording': name, 'note': 'no checksums'} for name in 'abcd']
    answer = {'notes': [*notes, {'recording': 'b', 'note': '3 samples'}]}
    assert list(note_lines(answer)) == ['a, b, c, d: no checksums', 'b: 3 samples']
    assert next(note_lines(answer, 2)) == 'a, b and 2 more: no checksums'


def test_ranking_says_what_was_fitted_and_what_was_chosen() -> None:
    rows = [
        {
            'names': ['stribeck'],
            'stage': stage,
            'gap_left': 0.2,
            'probability': 0.5,
            'chosen': chosen,
        }
        for stage, chosen in (('regression', True), ('screened', False))
    ]
    assert [(one.stage, one.chosen) for one in ranking({'candidates': rows}, 5)] == [
        ('fitted', True),
        ('screened', False),
    ]


def test_what_to_measure_next_may_be_a_recording_like_another() -> None:
    plan = {'like': 'run_1', 'by': 3.04, 'separates': ['a', 'b']}
    first, second, third = next_lines({'next_experiment': plan})
    assert first == 'a longer recording like run_1'
    assert '3.0 standard deviations' in second
    assert third == 'a, b'


def test_what_no_experiment_tells_apart_is_said_so() -> None:
    plan = {'like': 'run_1', 'by': 0.02, 'separates': ['a', 'b']}
    _, second, third = next_lines({'next_experiment': plan})
    assert 'not separable' in second
    assert third == 'a, b'


def test_kind_of_each_candidate_is_told() -> None:
    names = [
        ['stribeck'],
        ['valve.intake_voltage'],
        ['conditions.load_mass'],
        ['chamber_leak', 'line_lag'],
        ['chamber_leak', 'valve.intake_voltage'],
    ]
    rows = [
        {
            'names': one,
            'stage': 'regression',
            'gap_left': 0.1,
            'probability': None,
            'chosen': False,
        }
        for one in names
    ]
    kinds = [one.kind for one in ranking({'candidates': rows}, 5)]
    assert kinds == ['effect', 'parameter', 'condition', 'effects', 'mixed']
