# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a machine has of what the tool and the nodes need, and what to do where it has not."""

import os
import platform
import resource
import sys
import tempfile
from collections.abc import Iterator, Sequence
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from sosml_friction.report.common.table import FittingTable, terminal_table

FORMAT = 'sosml_friction/doctor/1'
#: Verdicts: there; not there, which some can do without; not there, and all need it.
GOOD, OPTIONAL, MISSING = 'good', 'optional', 'missing'
#: What every command imports, by the names of PyPI.
_NEEDED = (
    'numpy',
    'scipy',
    'numba',
    'matplotlib',
    'mcap',
    'cantools',
    'python-can',
    'typer',
    'rich',
)
#: Import, and what it is for.
_EXTRAS = {
    'h5py': 'HDF5 and MAT files of version 7.3: pip install h5py',
    'openpyxl': 'Excel files: pip install openpyxl',
    'pyarrow': 'Parquet: pip install pyarrow',
    'rosbags': 'bags of ROS 1: pip install rosbags',
    'mujoco': 'models of MuJoCo: pip install mujoco',
}
#: Of a CAN interface in /sys/class/net: ARPHRD_CAN of linux/if_arp.h.
_CAN_KIND = '280'
#: What ROS 2 uses where nothing else is said.
_RMW = 'rmw_fastrtps_cpp'
_NET = Path('/sys/class/net')


class Finding(NamedTuple):
    """Hold one thing that was looked at: its verdict, what was found, what to do about it."""

    name: str
    verdict: str
    found: str
    advice: str = ''


def examine() -> list[Finding]:
    """Return what was found on this machine."""
    return [*_software(), _cache(), *_ros(), *_buses(), _real_time(), *_extras()]


def _installed(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ''


def _checked(name: str, good: bool, found: str, advice: str, otherwise: str = OPTIONAL) -> Finding:
    """Return a finding with its advice, which is for one that is not good."""
    return Finding(name, GOOD if good else otherwise, found, '' if good else advice)


def _software() -> Iterator[Finding]:
    yield Finding('sosml_friction', GOOD, _installed('sosml_friction') or 'not installed by pip')
    new = sys.version_info >= (3, 10)
    python = platform.python_version()
    yield _checked('Python', new, python, 'use Python 3.10 to 3.13', MISSING)
    absent = [name for name in _NEEDED if not _installed(name)]
    told = ', '.join(f'{name} {own}' for name in _NEEDED if (own := _installed(name)))
    advice = f'install {", ".join(absent)}: make install, or pip install .'
    yield _checked('libraries', not absent, told, advice, MISSING)
    there = find_spec('pinocchio') is not None
    advice = 'pip install pin, or on ROS 2 apt install ros-jazzy-pinocchio'
    yield _checked('Pinocchio', there, 'found' if there else 'no', advice, MISSING)


def _cache() -> Finding:
    """Tell whether compiled code is kept: else each command compiles it anew."""
    folder = Path(os.environ.get('NUMBA_CACHE_DIR') or Path(__file__).parents[2])
    try:
        with tempfile.TemporaryFile(dir=folder):
            return Finding('cache', GOOD, f'{folder} can be written')
    except OSError:
        return Finding(
            'cache', OPTIONAL, f'{folder} cannot be written',
            'export NUMBA_CACHE_DIR=$HOME/.cache/numba, or each start compiles for a minute',
        )  # fmt: skip


def _ros() -> Iterator[Finding]:
    if find_spec('rclpy') is None:
        yield Finding('ROS 2', OPTIONAL, 'no rclpy',
                      'only the nodes need it: make install brings it, or source '
                      '/opt/ros/jazzy/setup.bash')  # fmt: skip
        return
    distribution = os.environ.get('ROS_DISTRO')
    yield Finding('ROS 2', GOOD, f'{distribution} is sourced' if distribution else 'from PyPI')
    name = os.environ.get('RMW_IMPLEMENTATION') or _RMW
    if find_spec(name) is None and name != _RMW and not _in_distribution(name):
        yield Finding('middleware', OPTIONAL, f'{name} is not installed',
                      'unset RMW_IMPLEMENTATION, or install what it names')  # fmt: skip
        return
    domain = os.environ.get('ROS_DOMAIN_ID', '0')
    yield Finding('middleware', GOOD, f'{name}, domain {domain}')


def _in_distribution(package: str) -> bool:
    """Tell whether a sourced distribution of ROS 2 has a package."""
    marker = Path('share', 'ament_index', 'resource_index', 'packages', package)
    prefixes = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    return any((Path(prefix) / marker).is_file() for prefix in prefixes if prefix)


def _buses() -> Iterator[Finding]:
    found = []
    for place in sorted(_NET.glob('*/type')) if _NET.is_dir() else ():
        if place.read_text().strip() == _CAN_KIND:
            state = (place.parent / 'operstate').read_text().strip()
            found.append((place.parent.name, state))
    told = ', '.join(f'{name} ({state})' for name, state in found)
    down = [name for name, state in found if state == 'down']
    advice = (
        'only the driver needs one; an adapter on a serial port is opened by can_interface:=slcan'
    )
    if down:
        advice = f'sudo ip link set {down[0]} up type can bitrate 1000000'
    yield _checked('CAN', bool(found) and not down, told or 'no interface', advice)
    ports = [*Path('/dev').glob('ttyACM*'), *Path('/dev').glob('ttyUSB*')]
    closed = [port for port in ports if not os.access(port, os.R_OK | os.W_OK)]
    if closed:
        yield Finding('serial port', OPTIONAL, f'{closed[0]} cannot be opened',
                      'sudo usermod -aG dialout $USER, then log in anew')  # fmt: skip


def _real_time() -> Finding:
    """Tell whether a node may ask for a priority of real time."""
    most = resource.getrlimit(resource.RLIMIT_RTPRIO)[1]
    told = f'priority up to {most}' if most else 'not permitted'
    root = os.geteuid() == 0
    return _checked(
        'real time', root or most != 0, 'root' if root else told,
        'only a driver on a busy machine needs it: a line "@realtime - rtprio 80" in '
        '/etc/security/limits.d/realtime.conf, yourself in that group, then log in anew',
    )  # fmt: skip


def _extras() -> Iterator[Finding]:
    for name, what in _EXTRAS.items():
        there = find_spec(name) is not None
        use, _, advice = what.partition(': ')
        yield _checked(name, there, _installed(name) if there else f'no ({use})', advice)


def machine_document(found: Sequence[Finding]) -> dict[str, Any]:
    """Return the object of ``sosml doctor --json``: docs/schema/doctor.schema.json."""
    ready = all(one.verdict != MISSING for one in found)
    return {'format': FORMAT, 'ready': ready, 'findings': [x._asdict() for x in found]}


def machine_table(found: Sequence[Finding]) -> FittingTable:
    """Return what was found as a table."""
    rows = [(one.name, one.verdict, one.found, one.advice) for one in found]
    return terminal_table({'what': 'w', 'verdict': 'w', 'found': '', 'what to do': ''}, rows)


def machine_sentence(found: Sequence[Finding]) -> str:
    """Return in a sentence what this machine can do."""
    missing = [one.name for one in found if one.verdict == MISSING]
    if missing:
        return f'Missing, and needed by every command: {", ".join(missing)}.'
    absent = [one.name for one in found if one.verdict == OPTIONAL]
    rest = f' Not there, and not needed by all: {", ".join(absent)}.' if absent else ''
    return f'Everything that sosml needs is here.{rest}'
