# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A thread that runs before others, in a process that is not paged out: where it is permitted."""

import ctypes
import os
import resource
from pathlib import Path

# CAP_IPC_LOCK of <linux/capability.h>, which no limit holds for.
_IPC_LOCK = 14
# Of <sys/mman.h>: what is there, what comes, and that only once it is used.
_CURRENT, _FUTURE, _ON_FAULT = 1, 2, 4


def take_real_time(thread: int, priority: int) -> str:
    """
    Give a thread SCHED_FIFO, and lock its process's memory; ``priority`` 0 asks for nothing.

    Return what is not permitted and how to grant it, '' if nothing is lacking. Threads that it
    starts do not inherit the policy.
    """
    if not priority:
        return ''
    lacking = []
    try:
        policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
        os.sched_setscheduler(thread, policy, os.sched_param(priority))
    except (AttributeError, OSError):
        lacking.append(f'rtprio {priority}')
    if not _lock_memory():
        lacking.append('memlock unlimited')
    if not lacking:
        return ''
    return (
        f'the cycle runs like any other program, as {" and ".join(lacking)} '
        f'{"is" if len(lacking) == 1 else "are"} not granted to it: for even cycles on a busy '
        'machine, write it for this user to /etc/security/limits.d and log in anew (in a '
        'container: the capabilities SYS_NICE and IPC_LOCK); realtime_priority 0 asks for nothing'
    )


def _lock_memory() -> bool:
    """Lock the pages that are in use now and later; tell whether it is permitted."""
    # Within a limit, whatever is allocated beyond it later would fail.
    limit, _ = resource.getrlimit(resource.RLIMIT_MEMLOCK)
    if limit != resource.RLIM_INFINITY and not _may_lock():
        return False
    try:
        return bool(ctypes.CDLL(None).mlockall(_CURRENT | _FUTURE | _ON_FAULT) == 0)
    except (AttributeError, OSError):
        return False


def _may_lock() -> bool:
    try:
        status = Path('/proc/self/status').read_text()
    except OSError:
        return False
    capabilities = [line.split()[1] for line in status.splitlines() if line.startswith('CapEff:')]
    return any(int(mask, 16) >> _IPC_LOCK & 1 for mask in capabilities)
