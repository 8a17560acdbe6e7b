"""What the package is and needs, for colcon (an ordinary ament_python package) and for pip."""

from glob import glob

from setuptools import find_packages, setup

package = 'pneu_rig_ros'
node_names = [
    'plant',
    'valve_command',
    'friction_estimator',
    'recorder',
    'rig',
    'excitation',
    'position_controller',
    'joint_command',
    'replay',
    'shadow',
]

setup(
    name=package,
    version='0.1.0',
    description='Emulated pneumatic servo rig for ROS 2: plant, valves, friction, recording.',
    license='Apache-2.0',
    maintainer='pneu_rig_ros maintainers',
    maintainer_email='maintainers@pneu-rig-ros.example',
    packages=find_packages(include=[package, f'{package}.*']),
    package_data={package: ['py.typed', 'report/*.html', 'web/assets/*']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{package}']),
        (f'share/{package}', ['package.xml']),
        *(
            (f'share/{package}/{folder}', sorted(glob(f'{folder}/*.*')))
            for folder in sorted(glob('config/**/', recursive=True))
        ),
        (f'share/{package}/launch', sorted(glob('launch/*.py'))),
    ],
    python_requires='>=3.10',
    install_requires=[
        'aiohttp>=3.9',
        "backports.zstd; python_version < '3.14'",  # there it is in the standard library
        'click',
        'jinja2',
        'lz4',
        'matplotlib',
        'mcap>=1.6',
        'numba',
        'numpy',
        'pyyaml',
        'rich',
        'rosbags',
        'scipy',
    ],
    extras_require={
        # ROS 2 from wheels. An extra, so that installing beside an apt ROS 2 never disturbs it.
        'ros': [
            'ros-jazzy-diagnostic-msgs',
            'ros-jazzy-rclpy[fastrtps]',
            'ros-jazzy-rosgraph-msgs',
            'ros-jazzy-sensor-msgs',
            'ros-jazzy-std-msgs',
            'ros-jazzy-std-srvs',
        ],
        # The same of Kilted, instead of it; `make` installs Jazzy.
        'kilted': [
            'ros-kilted-diagnostic-msgs',
            'ros-kilted-rclpy[fastrtps]',
            'ros-kilted-rosgraph-msgs',
            'ros-kilted-sensor-msgs',
            'ros-kilted-std-msgs',
            'ros-kilted-std-srvs',
        ],
        'test': [
            'catkin_pkg',
            'colcon-common-extensions',
            'hypothesis',
            'jsonschema',
            'mcap-ros2-support',
            'mypy',
            'packaging',
            'playwright',  # drives the Chromium of the system
            'psutil',
            'pytest<9.2',  # from there pytest-xdist 3.8 loses its groups (its issue 1386)
            'pytest-timeout',
            'pytest-xdist',
            'ruff',
            'setuptools<80',  # for colcon-core, which takes none above; a wheel builds with any
            'types-PyYAML',
            'yourdfpy',
        ],
        # For other units than SI, and Parquet. An extra, as rosdep knows neither.
        'tables': ['pint', 'pyarrow'],
        # For --scheduler. An extra for the same reason.
        'scale': ['distributed'],
        'bench': ['cma', 'psutil', 'scikit-sundae'],
        'docs': ['furo', 'myst-parser', 'sphinx'],
    },
    zip_safe=True,
    entry_points={
        'console_scripts': [
            *(f'{node} = {package}.nodes.{node}:main' for node in node_names),
            f'pneu-rig = {package}.cli:main',
        ],
    },
)
