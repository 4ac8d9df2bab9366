# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Real time where the system permits it, and what to grant where it does not."""

import ctypes
import os
import resource
import threading
from types import SimpleNamespace

import pytest

from sosml_friction.actuators.driver import real_time
from sosml_friction.actuators.driver.real_time import take_real_time


@pytest.fixture
def system(monkeypatch):
    """Return what is asked of a system that grants everything, or what a test takes away."""
    asked = SimpleNamespace(policies=[], locks=[], refuses=False, limit=resource.RLIM_INFINITY)

    def schedule(thread, policy, parameters):
        if asked.refuses:
            raise PermissionError
        asked.policies.append((thread, policy, parameters.sched_priority))

    def lock(flags):
        asked.locks.append(flags)
        return -1 if asked.refuses else 0

    monkeypatch.setattr(os, 'sched_setscheduler', schedule)
    monkeypatch.setattr(ctypes, 'CDLL', lambda _: SimpleNamespace(mlockall=lock))
    monkeypatch.setattr(resource, 'getrlimit', lambda _: (asked.limit, asked.limit))
    return asked


def test_what_is_permitted_is_taken_for_that_thread_alone(system):
    assert take_real_time(123, 50) == ''
    assert system.policies == [(123, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, 50)]
    assert len(system.locks) == 1


def test_zero_asks_for_nothing(system):
    assert take_real_time(123, 0) == ''
    assert not system.policies
    assert not system.locks


def test_what_is_refused_is_said_with_what_to_grant(system):
    system.refuses = True
    said = take_real_time(123, 40)
    assert 'rtprio 40 and memlock unlimited are not granted' in said
    assert '/etc/security/limits.d' in said
    assert '\n' not in said


def test_memory_is_not_locked_within_a_limit_that_later_allocations_would_meet(
    system, monkeypatch
):
    system.limit = 10**9
    monkeypatch.setattr(real_time, '_may_lock', lambda: False)
    assert 'as memlock unlimited is not granted' in take_real_time(123, 50)
    assert not system.locks
    monkeypatch.setattr(real_time, '_may_lock', lambda: True)
    assert take_real_time(123, 50) == ''


def test_the_policy_is_that_of_the_thread_or_the_sentence_says_it_is_not():
    stop = threading.Event()
    thread = threading.Thread(target=stop.wait)
    thread.start()
    try:
        said = take_real_time(thread.native_id, 7)
        policy = os.sched_getscheduler(thread.native_id)
        has = policy & ~os.SCHED_RESET_ON_FORK == os.SCHED_FIFO
        assert has != ('rtprio 7' in said)
        assert os.sched_getscheduler(0) == os.SCHED_OTHER
    finally:
        stop.set()
        thread.join()
        # What was locked stays so in a process that has much else to do.
        ctypes.CDLL(None).munlockall()
