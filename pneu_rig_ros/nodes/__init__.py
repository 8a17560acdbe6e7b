"""The rig on ROS 2: thin nodes around the plant, the valve drive, Eq. 2 and the bag writer."""

import os
import sys
from pathlib import Path

from pneu_rig_ros.rig.configuration import configuration_folder

OWNER = 'PNEU_RIG_OWNER'
"""Environment variable: number of the process without which a node does not go on."""

PROFILES = 'FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE'
"""Where Fast DDS looks for its settings; the second since Kilted."""


def _middlewares() -> set[str]:
    """Return the names of the ROS middlewares that are installed, as far as can be known."""
    prefixes = [*os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep), sys.prefix]
    index = Path('share', 'ament_index', 'resource_index', 'rmw_typesupport')
    found = (path.name for prefix in prefixes if prefix for path in Path(prefix, index).glob('*'))
    return set(found) - {'rmw_implementation'}


def _check_middleware() -> None:
    """End in good order where ROS would end the process with code 102 while it is imported."""
    wanted, known = os.environ.get('RMW_IMPLEMENTATION', ''), _middlewares()
    if wanted and known and wanted not in known:
        print(
            f'Error: RMW_IMPLEMENTATION={wanted} is not installed, '
            f'allowed: {", ".join(sorted(known))}',
            file=sys.stderr,
        )
        raise SystemExit(2)


_check_middleware()
if not any(name in os.environ for name in PROFILES):
    os.environ |= dict.fromkeys(PROFILES, str(configuration_folder() / 'fastdds.xml'))
