# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Functions compiled by Numba, once for all processes."""

import fcntl
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from numba import njit
from numba.core.compiler_lock import global_compiler_lock


@cache
def _latest_change() -> int:
    return max(path.stat().st_mtime_ns for path in Path(__file__).parent.rglob('*.py'))


def compiled(function: Callable[..., Any]) -> Any:
    """
    Compile ``function`` for each combination of types at its first call; keep it on disk.

    One process at a time: the others wait and load what it made. Numba would let all of them
    compile, and where two do so for two types at once write both to one file (its issue 4807), so
    that each later start loads code for the wrong type. And it knows of changes to a function's
    own file, not to those of the functions that it calls.
    """
    dispatcher: Any = njit(cache=True)(function)
    if not hasattr(dispatcher, '_cache'):
        # NUMBA_DISABLE_JIT: the function itself.
        return dispatcher
    kept, compile_here = dispatcher._cache, dispatcher.compile
    known = kept._cache_file
    known._source_stamp = (known._source_stamp, _latest_change())
    # A lock for each function: a function waits for those that it calls, and never the reverse.
    name = f'{function.__module__}.{function.__qualname__}.{function.__code__.co_firstlineno}.lock'

    def compile_alone(signature: Any) -> Any:
        folder = Path(kept.cache_path)
        folder.mkdir(parents=True, exist_ok=True)
        # Numba's lock first, as for the functions that this one calls: threads would else wait
        # for each other.
        with global_compiler_lock, (folder / name).open('w') as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            return compile_here(signature)

    dispatcher.compile = compile_alone
    return dispatcher
