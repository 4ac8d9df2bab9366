# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One function of a test for one seed, or for many on two processes."""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from typing import Any

from sosml_friction.study.parallel import run_all, workers


def over_seeds(file: str, function: str, seeds: Sequence[int], *arguments: Any) -> list[Any]:
    """
    Return what ``function(seed, *arguments)`` of the test in ``file`` returns, by seed.

    One seed needs no other process, and none of its imports. For more the processes are new ones:
    a copy of this one would have to collect what other tests left, objects of libraries whose
    threads it has not, and one such copy ended in a segmentation fault.
    """
    tasks = [(file, function, seed, *arguments) for seed in seeds]
    if len(tasks) == 1:
        return [_call(tasks[0])]
    with workers(min(2, len(tasks))) as pool:
        return run_all(pool, _call, tasks)


def _call(task: tuple[Any, ...]) -> Any:
    file, function, *arguments = task
    # By its path: a new process finds no module of a test by name.
    spec = importlib.util.spec_from_file_location('over_seeds_test', file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return getattr(module, function)(*arguments)
