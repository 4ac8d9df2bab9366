# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a busy recorder does to a recording."""

from dataclasses import replace

import numpy as np

from sosml_friction.bags.joint_log import JointLog


def with_losses(log: JointLog, rng: np.random.Generator) -> JointLog:
    """
    Return a log without 8 % of its samples, in bursts of two in the mean, stamped late.

    Delays are exponential, of 8 % of a step in the mean.
    """
    lost = np.zeros(len(log), dtype=bool)
    for first in np.flatnonzero(rng.random(len(log)) < 0.04):
        lost[first : first + rng.geometric(0.5)] = True
    late = rng.exponential(0.08 * log.step, len(log))
    t_ns = log.t_ns + np.rint(1e9 * late).astype(np.int64)
    return replace(log, t_ns=t_ns).rows(np.flatnonzero(~lost))
