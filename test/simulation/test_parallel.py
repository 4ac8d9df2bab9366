# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Work on processes: results in order, errors told, nothing left running."""

import math
import multiprocessing
import os

import pytest

from sosml_friction.exceptions import DataError
from sosml_friction.simulation.parallel import available_cores, run_all, workers


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
