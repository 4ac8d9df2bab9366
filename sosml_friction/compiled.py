# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Functions compiled by Numba, once for all processes."""

import fcntl
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from numba import njit
from numba.core.caching import FunctionCache


@cache
def _latest_change() -> int:
    return max(path.stat().st_mtime_ns for path in Path(__file__).parent.rglob('*.py'))


class _SharedCache(FunctionCache):  # type: ignore[misc]
    """
    Numba's own, where it does not see other processes nor other files.

    It lets two processes that compile a function for two types at once write both to one file (its
    issue 4807), and each later start loads code for the wrong type: so they save under a lock. It
    knows of changes to a function's own file, not to those of the functions that it calls.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        known = self._cache_file
        known._source_stamp = (known._source_stamp, _latest_change())

    def save_overload(self, signature: Any, compiled: Any) -> None:
        self._impl.locator.ensure_cache_path()
        with (Path(self.cache_path) / '.lock').open('w') as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            super().save_overload(signature, compiled)


def compiled(function: Callable[..., Any]) -> Any:
    """Compile ``function`` for each combination of types at its first call; keep it on disk."""
    dispatcher: Any = njit(function)
    dispatcher._cache = _SharedCache(function)
    return dispatcher
