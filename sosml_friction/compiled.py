# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Functions compiled by Numba, once for all processes."""

import fcntl
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from numba import njit


@cache
def _latest_change() -> int:
    return max(path.stat().st_mtime_ns for path in Path(__file__).parent.rglob('*.py'))


def compiled(function: Callable[..., Any]) -> Any:
    """
    Compile ``function`` for each combination of types at its first call; keep it on disk.

    Numba lets two processes that compile a function for two types at once write both to one file
    (its issue 4807), and each later start loads code for the wrong type: they save under a lock.
    And it knows of changes to a function's own file, not to those of the functions that it calls.
    """
    dispatcher: Any = njit(cache=True)(function)
    if not hasattr(dispatcher, '_cache'):
        # NUMBA_DISABLE_JIT: the function itself.
        return dispatcher
    kept = dispatcher._cache
    save, known = kept.save_overload, kept._cache_file
    known._source_stamp = (known._source_stamp, _latest_change())

    def save_alone(signature: Any, code: Any) -> None:
        folder = Path(kept.cache_path)
        folder.mkdir(parents=True, exist_ok=True)
        with (folder / '.lock').open('w') as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            save(signature, code)

    kept.save_overload = save_alone
    return dispatcher
