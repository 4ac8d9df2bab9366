# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Work on processes: results in order, errors told, nothing left running."""

import math
import multiprocessing
import os
import select
import signal
import subprocess
import sys

import pytest

from sosml_friction.exceptions import DataError
from sosml_friction.study.parallel import available_cores, run_all, workers


@pytest.mark.parametrize('count', [1, 2])
def test_results_come_in_the_order_of_the_tasks(count):
    done = []
    with workers(count) as pool:
        assert run_all(pool, math.sqrt, [9.0, 4.0, 1.0], done.append) == [3.0, 2.0, 1.0]
    assert done == [1, 2, 3]
    assert multiprocessing.active_children() == []


def test_an_error_comes_through_and_ends_the_processes():
    with pytest.raises(ValueError, match='domain'), workers(2) as pool:
        run_all(pool, math.sqrt, [1.0, -1.0])
    assert multiprocessing.active_children() == []


def test_ctrl_c_ends_the_processes_at_once():
    import time

    def interrupt(count):
        raise KeyboardInterrupt

    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt), workers(2) as pool:
        run_all(pool, time.sleep, [0.0, 600.0], interrupt)
    # Far below the sleep of the other process, which is therefore gone.
    assert time.monotonic() - begun < 300.0
    assert multiprocessing.active_children() == []


def test_a_process_that_is_killed_is_told_in_a_sentence():
    with pytest.raises(DataError, match='ended from outside'), workers(2) as pool:
        run_all(pool, os._exit, [3])


def test_there_is_at_least_one_core():
    assert available_cores() >= 1


#: A computation with one process busy and one idle; prints their numbers once that is so.
COMPUTATION = """
import multiprocessing, time
from sosml_friction.study.parallel import workers
with workers(2) as pool:
    first, second = (pool.submit(time.sleep, seconds) for seconds in (0.0, 600.0))
    first.result()
    print(*(child.pid for child in multiprocessing.active_children()), flush=True)
    second.result()
"""


def test_a_computation_that_is_killed_leaves_no_process_behind():
    """SIGKILL, which it cannot answer; a process still there after a minute would stay."""
    with subprocess.Popen(
        [sys.executable, '-c', COMPUTATION], stdout=subprocess.PIPE, text=True
    ) as computation:
        handles = [os.pidfd_open(int(pid)) for pid in computation.stdout.readline().split()]
        assert len(handles) == 2
        computation.send_signal(signal.SIGKILL)
    gone = select.poll()
    for handle in handles:
        gone.register(handle, select.POLLIN)
    left = set(handles)
    try:
        while left:
            ended = gone.poll(60_000)
            assert ended
            for handle, _ in ended:
                gone.unregister(handle)
                left.discard(handle)
    finally:
        for handle in left:
            signal.pidfd_send_signal(handle, signal.SIGKILL)
        for handle in handles:
            os.close(handle)
