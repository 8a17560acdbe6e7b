"""What the tests of the blind trials share."""

from collections.abc import Callable
from contextlib import AbstractContextManager

import numpy as np
import pytest

from .plant import Plant
from .rig import INTERVAL
from .settings import settings


@pytest.fixture(autouse=True, scope='session')
def _compiled_once(one_worker: Callable[[str], AbstractContextManager[None]]) -> None:
    """Let one worker compile the second plant."""
    with one_worker('second_plant'):
        Plant(settings('cylinder_1'), {}).run(np.full((1, 2), 2.5), INTERVAL)
