"""What the tests of the diagnosis share."""

import pytest


@pytest.fixture(autouse=True, scope='session')
def _compiled_once(plants: None) -> None:
    """Have the plants of all diagnoses compiled."""
