# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Efforts of exactly 0 amid others that are far from it: readings that were lost."""

from dataclasses import replace

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.observers.signal_noise import signal_noise

#: An effort is far from 0 beyond this many standard deviations of its noise, of which as many
#: beyond are one in 5e8, and this many counts: it rounds to 0 from half of one.
_SIGMAS, _COUNTS = 6.0, 2.0


def zero_efforts(tau: FloatArray) -> BoolArray:
    """
    Return which efforts (N,) are 0 between two of one sign that are far from it, and are none.

    Of one sample at a time: a drive that is off is so for longer.
    """
    count, noise = signal_noise(tau)
    far = max(_SIGMAS * noise, _COUNTS * count)
    found = np.zeros(len(tau), dtype=bool)
    before, own, after = tau[:-2], tau[1:-1], tau[2:]
    least = np.minimum(np.abs(before), np.abs(after))
    found[1:-1] = (own == 0.0) & (before * after > 0.0) & (least > far)
    return found


def without_zero_efforts(log: JointLog) -> tuple[JointLog, dict[str, str]]:
    """Return the log without such efforts, NaN in their place, and what is said by joint."""
    lost = np.column_stack([zero_efforts(tau) for tau in log.tau.T])
    told = {
        name: (
            f'the effort of joint {name} is exactly 0 in {own.sum()} single samples between '
            f'others far from it, first at {log.time[np.argmax(own)]:.4g} s: these readings '
            'were lost, and are left out; see its bus'
        )
        for name, own in zip(log.names, lost.T, strict=True)
        if own.any()
    }
    return (replace(log, tau=np.where(lost, np.nan, log.tau)), told) if told else (log, told)
