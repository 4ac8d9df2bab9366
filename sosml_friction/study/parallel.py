# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Work on several processes, which Ctrl-C and a killed parent end at once."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import TypeVar

from sosml_friction.exceptions import DataError

Task = TypeVar('Task')
Result = TypeVar('Result')


def available_cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0))


@contextmanager
def workers(count: int) -> Iterator[Executor | None]:
    """
    Start processes that run tasks, and end them however the block is left.

    Yields what :func:`run_all` takes: None for one process, which is this one.
    """
    if count == 1:
        yield None
        return
    others = set(multiprocessing.active_children())
    # Not fork: this process may have threads, of a progress bar for one.
    pool = ProcessPoolExecutor(
        count, multiprocessing.get_context('spawn'), initializer=_prepare_worker
    )
    try:
        yield pool
    except BaseException:
        for child in set(multiprocessing.active_children()) - others:
            child.terminate()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def run_all(
    pool: Executor | None,
    function: Callable[[Task], Result],
    tasks: Sequence[Task],
    done: Callable[[int], None] = lambda count: None,
) -> list[Result]:
    """
    Return the results in the order of the tasks, whichever process computed them.

    :raises DataError: if a process was ended from outside.
    """
    if pool is None:
        results = []
        for task in tasks:
            results.append(function(task))
            done(len(results))
        return results
    futures = [pool.submit(function, task) for task in tasks]
    try:
        for count, future in enumerate(as_completed(futures), 1):
            future.result()
            done(count)
    except BrokenProcessPool as error:
        raise DataError(
            'a process of the computation was ended from outside, perhaps for want of memory: '
            'run it again, with fewer processes'
        ) from error
    return [future.result() for future in futures]


def _prepare_worker() -> None:
    # The terminal interrupts the whole group: the parent tells it, once.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    threading.Thread(target=_end_with_the_parent, daemon=True).start()


def _end_with_the_parent() -> None:
    # A parent that is killed cannot end its workers, and they would wait for tasks for ever.
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
