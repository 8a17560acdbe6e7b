"""The ROS 2 nodes, thin layers over the model, `control`, `analysis` and `records`."""

import os
import signal
import sys
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

OWNER = 'PNEU_RIG_OWNER'
"""Environment variable: number of the parent process, with which a node ends."""

PROFILES = {
    'FASTRTPS_DEFAULT_PROFILES_FILE': 'fastdds.xml',
    'FASTDDS_DEFAULT_PROFILES_FILE': 'fastdds_3.xml',
}
"""Environment variables that name the Fast DDS profiles, and ours; the second since Kilted."""

KILTED = 9
"""Major version of rclpy in Kilted, the first release with Fast DDS 3; Jazzy has 7."""


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


def _is_node() -> bool:
    """Return whether a module of this package is what the process runs: `plant`, `python -m`."""
    if sys.argv[0] == '-m':  # while Python looks for the module
        return any(f'{__name__}.' in word for word in sys.orig_argv)
    script = Path(sys.argv[0]).name
    return script.isidentifier() and find_spec(f'{__name__}.{script}') is not None


def _exit_on_signals() -> None:
    """
    End the process with code 0 on SIGINT and SIGTERM, until `runner` handles them.

    An exception would not do: extension modules may turn it into an ImportError.
    """
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: os._exit(0))


def _set_profiles() -> None:
    """Make Fast DDS read its profiles, unless the environment names others."""
    from pneu_rig_ros.rig.yaml_file import configuration_folder

    if not any(name in os.environ for name in PROFILES):
        name = tuple(PROFILES)[int(version('rclpy').partition('.')[0]) >= KILTED]
        os.environ[name] = str(configuration_folder() / PROFILES[name])


if _is_node():
    _exit_on_signals()  # first, as all else imports for a second
_check_middleware()
_set_profiles()
