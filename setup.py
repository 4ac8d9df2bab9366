# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Install sosml_friction: with pip into a virtual environment, or with colcon into a workspace.

In a plain environment pip brings ROS 2 (rclpy, Fast DDS, the messages) and Pinocchio as wheels.
Where a ROS 2 distribution is sourced its own packages are used: the wheels would shadow them and
mix two builds of the same shared libraries in one process, and those of Pinocchio need a newer
NumPy than the distribution's packages are compiled against.
"""

import os
import re
from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = 'sosml_friction'

# Lower bounds: what Ubuntu 24.04 has. Upper bounds: the next major version.
REQUIREMENTS = [
    'PyYAML>=6.0,<7',
    'cantools>=39,<46',
    'lz4>=4.0,<5',
    'matplotlib>=3.6,<4',
    'mcap>=1.5,<2',
    'numba>=0.60,<1',
    'numpy>=1.26,<3',
    'pyserial>=3.5,<4',
    'python-can>=4.3,<5',
    'rich>=13.7,<16',
    'scipy>=1.11,<2',
    'threadpoolctl>=3.1,<4',
    'typer>=0.12,<1',
    'typing_extensions>=4.6,<5',
    'zstandard>=0.22,<1',
]
# What stands in for a ROS 2 distribution: its rclpy, Fast DDS and messages, and Pinocchio.
ROS_REQUIREMENTS = [
    'pin>=3.2,<5',
    'ros-jazzy-common-interfaces>=5.3,<6',
    'ros-jazzy-rclpy[fastrtps]>=7.1,<8',
]
TEST_REQUIREMENTS = [
    'colcon-common-extensions>=0.3,<1',
    'hypothesis>=6.98,<7',
    'jsonschema>=4.17,<5',
    'mypy>=1.9,<3',
    'pytest>=7.4,<10',
    'pytest-xdist>=3.8,<4',
    'rosbags>=0.10,<1',
    'ruff>=0.17,<0.18',
    'setuptools>=70.1,<80',
    'types-PyYAML>=6.0,<7',
]
# HDF5 and MAT 7.3, Excel; what other files need to be imported: Parquet, bags of ROS 1.
TABLE_REQUIREMENTS = ['h5py>=3.8,<4', 'openpyxl>=3.1,<4']
IMPORT_REQUIREMENTS = [*TABLE_REQUIREMENTS, 'pyarrow>=15,<27', 'rosbags>=0.10,<1']
# For sosml fleet --scheduler.
DASK_REQUIREMENTS = ['distributed>=2024.5,<2027']
# For make docs alone.
DOCS_REQUIREMENTS = ['mkdocs-material>=9.5,<10']
# Simulators that a model is exported to and read from: 3.17 has the fields, 4.0 is the last tried.
MUJOCO_REQUIREMENTS = ['mujoco>=3.17,<5']
# For make mutants alone.
MUTANT_REQUIREMENTS = ['cosmic-ray>=8.4,<9']


def version():
    """Return __version__ of the package, without importing it."""
    text = Path(PACKAGE, '__init__.py').read_text(encoding='utf-8')
    return re.search(r"^__version__ = '(.+)'$", text, re.MULTILINE)[1]


def distribution_is_sourced():
    """Tell whether the shell has sourced a ROS 2 distribution that has rclpy."""
    prefixes = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    marker = Path('share', 'ament_index', 'resource_index', 'packages', 'rclpy')
    return bool(os.environ.get('ROS_DISTRO')) and any(
        (Path(prefix) / marker).is_file() for prefix in prefixes if prefix
    )


def data_files():
    """Return (folder in the prefix, files) pairs; subfolders of the source are kept."""
    share = Path('share', PACKAGE)
    pairs = {
        Path('share', 'ament_index', 'resource_index', 'packages'): [f'resource/{PACKAGE}'],
        share: ['package.xml'],
    }
    files = [
        *Path('config').rglob('*'),
        *Path('urdf').rglob('*'),
        *Path('launch').glob('*.launch.py'),
    ]
    for path in sorted(files):
        hidden = any(part.startswith(('.', '__pycache__')) for part in path.parts)
        if path.is_file() and not hidden:
            pairs.setdefault(share / path.parent, []).append(path.as_posix())
    return [(folder.as_posix(), names) for folder, names in pairs.items()]


setup(
    name=PACKAGE,
    version=version(),
    description='Friction of geared robot joints without a torque sensor: observe, identify.',
    author='the sosml_friction authors',
    maintainer='the sosml_friction authors',
    maintainer_email='maintainers@sosml-friction.example',
    license='Apache-2.0',
    # The ROS wheels exist for CPython 3.10 to 3.13; a distribution brings its own rclpy.
    python_requires='>=3.10' if distribution_is_sourced() else '>=3.10,<3.14',
    packages=find_packages(include=[PACKAGE, f'{PACKAGE}.*']),
    package_data={PACKAGE: ['py.typed', 'report/common/page.*']},
    data_files=data_files(),
    zip_safe=False,
    install_requires=REQUIREMENTS + ([] if distribution_is_sourced() else ROS_REQUIREMENTS),
    extras_require={
        'dask': DASK_REQUIREMENTS,
        'docs': DOCS_REQUIREMENTS,
        'import': IMPORT_REQUIREMENTS,
        'mujoco': MUJOCO_REQUIREMENTS,
        'mutants': MUTANT_REQUIREMENTS,
        'test': TEST_REQUIREMENTS + DASK_REQUIREMENTS + MUJOCO_REQUIREMENTS + TABLE_REQUIREMENTS,
    },
    entry_points={
        'console_scripts': [
            f'driver_node = {PACKAGE}.nodes.driver_node:main',
            f'emulator_node = {PACKAGE}.nodes.emulator_node:main',
            f'exoskeleton_node = {PACKAGE}.nodes.exoskeleton_node:main',
            f'identifier_node = {PACKAGE}.nodes.identifier_node:main',
            f'observer_node = {PACKAGE}.nodes.observer_node:main',
            f'replay_node = {PACKAGE}.nodes.replay_node:main',
            f'sosml = {PACKAGE}.cli.main:main',
        ],
    },
)
