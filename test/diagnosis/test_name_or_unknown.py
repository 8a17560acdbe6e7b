"""When a name stays the answer beside a description by empirical terms."""

import pytest

from pneu_rig_ros.diagnosis.search.name_or_unknown import NameTest

LIKELIER, SIMPLE = True, True


@pytest.mark.parametrize(
    'comparison',
    [
        NameTest(0.02, 0.02, 0.0, LIKELIER, not SIMPLE),  # next to nothing is left
        NameTest(0.19, 0.19, 0.15, LIKELIER, not SIMPLE),
        # the description leaves nothing that is significant, but is not likelier
        NameTest(0.17, 0.14, 0.0, not LIKELIER, SIMPLE),
        NameTest(0.40, 0.50, 0.39, LIKELIER, not SIMPLE),  # no difference, to the noise
        NameTest(0.45, 0.50, 0.90, not LIKELIER, not SIMPLE),
        # what is left under the given model is noise if the name is true
        NameTest(0.56, 0.13, 0.57, not LIKELIER, not SIMPLE),
        NameTest(0.10, 0.00, 0.00, not LIKELIER, not SIMPLE, is_effect=False),  # a weak parameter
        NameTest(0.90, 0.90, 0.80, LIKELIER, SIMPLE, discrepant=True),
    ],
)
def test_name_is_accepted(comparison: NameTest) -> None:
    assert comparison.accepts_name


@pytest.mark.parametrize(
    'comparison',
    [
        NameTest(0.30, 0.30, 0.20, LIKELIER, not SIMPLE),
        NameTest(0.19, 0.19, 0.05, LIKELIER, not SIMPLE),
        NameTest(0.10, 0.10, 0.10, LIKELIER, SIMPLE),
        NameTest(0.56, 0.30, 0.90, not LIKELIER, not SIMPLE),
        NameTest(0.40, 0.80, 0.90, not LIKELIER, not SIMPLE),
        NameTest(0.10, 0.30, 0.10, LIKELIER, not SIMPLE, is_effect=False),
        NameTest(0.30, 0.30, 0.90, not LIKELIER, not SIMPLE, is_effect=False),
        NameTest(0.00, 0.47, 1.00, not LIKELIER, not SIMPLE, is_effect=False),
        NameTest(0.96, 0.10, 0.97, not LIKELIER, not SIMPLE),
        NameTest(0.90, 0.90, 0.40, LIKELIER, not SIMPLE, discrepant=True),
    ],
)
def test_description_takes_its_place(comparison: NameTest) -> None:
    assert not comparison.accepts_name


def test_more_left_never_keeps_a_name_that_less_would_lose() -> None:
    shares = [0.02 * i for i in range(50)]
    for likelier in (True, False):
        stays = [NameTest(s, 0.5, 0.3, likelier, not SIMPLE).accepts_name for s in shares]
        assert stays == sorted(stays, reverse=True)
