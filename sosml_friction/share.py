# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Find the package's installed data: config/, urdf/ and launch/."""

import os
import sys
from pathlib import Path

from sosml_friction.exceptions import ConfigurationError

PACKAGE = 'sosml_friction'
# Of a prefix's lib/python3.x/site-packages/sosml_friction, how far up the prefix can be.
_LEVELS_TO_PREFIX = 4


def share_directory() -> Path:
    """
    Return the folder that holds ``config/``, ``urdf/`` and ``launch/``.

    Data that belongs to the running code comes before any other. Looked for in this order: the
    source tree this module is in (editable installation, ``colcon build --symlink-install``), the
    prefix this module is installed in (pip, colcon, distribution), the prefixes in
    AMENT_PREFIX_PATH, and the running interpreter's prefix.

    :raises ConfigurationError: if none of them holds the package's data.
    """
    package = Path(__file__).resolve().parent
    source_tree = package.parent
    if (source_tree / 'package.xml').is_file() and (source_tree / 'config').is_dir():
        return source_tree
    prefixes = list(package.parents[:_LEVELS_TO_PREFIX])
    prefixes += [Path(p) for p in os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep) if p]
    prefixes.append(Path(sys.prefix))
    for prefix in prefixes:
        share = prefix / 'share' / PACKAGE
        if (share / 'config').is_dir():
            return share
    raise ConfigurationError(
        f'the data of {PACKAGE} (config/, urdf/) is neither beside its code in {package} nor in '
        f'AMENT_PREFIX_PATH or {sys.prefix}: install the package again'
    )
