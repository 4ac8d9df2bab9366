# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Efforts of exactly 0 amid others that are far from it: readings that were lost."""

from dataclasses import replace

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.observers.signal_noise import signal_noise
from sosml_friction.regression.kernels import runs

#: Most readings in a row that are lost: as many as are bridged. Longer ones are of a drive that is
#: off.
_LONGEST = 4
#: An effort is far from 0 beyond this many standard deviations of its noise, of which as many
#: beyond are one in 5e8, and this many counts: it rounds to 0 from half of one.
_SIGMAS, _COUNTS = 6.0, 2.0


def zero_efforts(tau: FloatArray) -> BoolArray:
    """
    Return which efforts (N,) are 0 and no measurements.

    One between two of one sign that are far from it is none. Where there are such, others that are
    0 may be none either.
    """
    count, noise = signal_noise(tau)
    far = max(_SIGMAS * noise, _COUNTS * count)
    short = [
        (begin, end)
        for begin, end in runs(tau == 0.0)
        if begin > 0 and end < len(tau) and end - begin <= _LONGEST
    ]
    flanks = [(float(tau[begin - 1]), float(tau[end])) for begin, end in short]
    found = np.zeros(len(tau), dtype=bool)
    if any(a * b > 0.0 and min(abs(a), abs(b)) > far for a, b in flanks):
        for begin, end in short:
            found[begin:end] = True
    return found


def without_zero_efforts(log: JointLog) -> tuple[JointLog, dict[str, str]]:
    """Return the log without such efforts, NaN in their place, and what is said by joint."""
    lost = np.column_stack([zero_efforts(tau) for tau in log.tau.T])
    told = {
        name: (
            f'the effort of joint {name} is exactly 0 in {own.sum()} samples, between others far '
            f'from it, first at {log.time[np.argmax(own)]:.4g} s: readings were lost, and these '
            'are left out; see its bus'
        )
        for name, own in zip(log.names, lost.T, strict=True)
        if own.any()
    }
    return (replace(log, tau=np.where(lost, np.nan, log.tau)), told) if told else (log, told)
