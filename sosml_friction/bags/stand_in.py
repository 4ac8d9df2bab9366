# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Files that stand where a recording should be."""

from pathlib import Path

from sosml_friction.exceptions import DataError

#: By the first bytes, in small letters: what it is, and how the file itself is had.
_KINDS = {
    b'version https://git-lfs': ('a pointer of Git LFS', 'fetch it with git lfs pull'),
    b'/annex/objects/': ('a pointer of git-annex', 'fetch it with git annex get'),
    b'<!doctype html': ('a web page', 'download the raw file'),
    b'<html': ('a web page', 'download the raw file'),
}


def refuse_stand_in(path: Path) -> None:
    """Refuse, with a DataError, a pointer or a web page in the place of a recording."""
    try:
        with path.open('rb') as stream:
            head = stream.read(64).lstrip().lower()
    except OSError:
        return
    for begin, (what, how) in _KINDS.items():
        if head.startswith(begin):
            raise DataError(f'{path} is {what}, and not the recording itself: {how}')
