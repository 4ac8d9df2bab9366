# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Samples in which a position is none, left out and told."""

from collections.abc import Callable

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.bags.joint_log import JointLog


def without_marked(
    log: JointLog,
    mark: Callable[[FloatArray, FloatArray], BoolArray],
    tell: Callable[[FloatArray, FloatArray, BoolArray], str],
) -> tuple[JointLog, dict[str, str]]:
    """
    Return the samples without those that are marked in any joint, and what is said by joint.

    :param mark: returns which positions (N,) are none, of stamps (N,) [s] and positions (N,).
    :param tell: returns what is said of a joint's, of the same and of what is marked.
    """
    bad = np.column_stack([mark(log.time, q) for q in log.q.T])
    told = {
        name: f'the position of joint {name} {tell(log.time, q, own)}; see its encoder and cable'
        for name, q, own in zip(log.names, log.q.T, bad.T, strict=True)
        if own.any()
    }
    return (log.rows(np.flatnonzero(~bad.any(axis=1))), told) if told else (log, told)
