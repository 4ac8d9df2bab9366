# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The files of a bag."""

import re
from pathlib import Path

from sosml_friction.exceptions import BagError


def mcap_files(path: Path) -> list[Path]:
    """Return the MCAP files of a bag in the order they were recorded, at least one."""
    if not path.exists():
        raise BagError(f'{path} does not exist: give a bag folder or file')
    if path.is_file():
        return [path]
    try:
        names = sorted(file.name for file in path.iterdir() if file.is_file())
    except OSError as error:
        raise BagError(f'{path} cannot be read: {error.strerror}') from error
    files = [name for name in names if name.endswith('.mcap')]
    if files:
        # name_2.mcap comes before name_10.mcap.
        files.sort(
            key=lambda name: [int(p) if p.isdigit() else p for p in re.split(r'(\d+)', name)]
        )
        return [path / name for name in files]
    packed = [name for name in names if name.endswith(('.mcap.zstd', '.db3.zstd'))]
    if packed:
        raise BagError(
            f'{path} holds compressed files only ({packed[0]}): unpack them with `zstd -d`, or '
            'record with --storage-preset-profile zstd_fast, which is read directly'
        )
    raise BagError(
        f'{path} is no bag: the folder holds no .mcap or .db3 file; give the folder of one bag'
    )
