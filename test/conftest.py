"""What all tests share."""

import pytest
from hypothesis import settings

# the machine may be busy with live nodes; how long an example takes says nothing
settings.register_profile('steady', deadline=None)
settings.load_profile('steady')


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Give all live tests to one worker, so that they do not take each other's processor time."""
    for item in items:
        if item.get_closest_marker('live'):
            item.add_marker(pytest.mark.xdist_group('live'))
