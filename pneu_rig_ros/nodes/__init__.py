"""The ROS 2 nodes, thin layers over the model, `control`, `analysis` and `records`."""

import os
import sys
from pathlib import Path
from types import TracebackType

OWNER = 'PNEU_RIG_OWNER'
"""Environment variable: number of the parent process, with which a node ends."""

PROFILES = 'FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE'
"""Environment variables with the Fast DDS profiles; the second one since Kilted."""


def _check_middleware() -> None:
    """Exit with code 2 and a message where importing rclpy would end the process with code 102."""
    requested = os.environ.get('RMW_IMPLEMENTATION', '')
    prefixes = [*os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep), sys.prefix]
    index = Path('share', 'ament_index', 'resource_index', 'rmw_typesupport')
    names = (path.name for prefix in prefixes if prefix for path in Path(prefix, index).glob('*'))
    installed = set(names) - {'rmw_implementation'}
    if requested and installed and requested not in installed:
        print(
            f'Error: RMW_IMPLEMENTATION={requested} is not installed, '
            f'allowed: {", ".join(sorted(installed))}',
            file=sys.stderr,
        )
        raise SystemExit(2)


def _quiet_interrupt(
    kind: type[BaseException], error: BaseException, trace: TracebackType | None
) -> None:
    """Report an exception, but not Ctrl-C while a node still imports its modules."""
    if not issubclass(kind, KeyboardInterrupt):
        sys.__excepthook__(kind, error, trace)


def _set_profiles() -> None:
    """Make Fast DDS read its profiles, unless the environment names others."""
    from pneu_rig_ros.rig.configuration import configuration_folder

    if not any(name in os.environ for name in PROFILES):
        os.environ |= dict.fromkeys(PROFILES, str(configuration_folder() / 'fastdds.xml'))


if sys.excepthook is sys.__excepthook__:
    sys.excepthook = _quiet_interrupt  # first, as all else imports for a second
_check_middleware()
_set_profiles()
