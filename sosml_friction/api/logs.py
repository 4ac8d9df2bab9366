# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Recordings as the functions of the interface take them."""

from collections.abc import Mapping, Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.identification.law_residual import position_difference


def labelled(logs: JointLog | Sequence[JointLog] | Mapping[str, JointLog]) -> dict[str, JointLog]:
    """
    Return recordings by label: their own, else ``log``, or ``log 1``, ``log 2``, ...

    :raises DataError: if there is none.
    :raises ConfigurationError: if something else is given, such as a path.
    """
    if isinstance(logs, Mapping):
        found = dict(logs)
    elif not isinstance(logs, (list, tuple)):
        found = {'log': one_log(logs)}
    elif len(logs) == 1:
        found = {'log': logs[0]}
    else:
        found = {f'log {k}': log for k, log in enumerate(logs, 1)}
    if not found:
        raise DataError('there is no recording: give at least one')
    return {label: one_log(log) for label, log in found.items()}


def one_log(log: object) -> JointLog:
    """
    Return a recording.

    :raises ConfigurationError: if something else is given, such as a path.
    """
    if not isinstance(log, JointLog):
        given = ' '.join(f'{log!r:.60}'.split())
        raise ConfigurationError(f'{given} is no recording: give what sf.load returns')
    return log


def velocity_of(log: JointLog) -> FloatArray:
    """Return velocity (N, n) [rad/s or m/s], of joints without it from differences of position."""
    v = log.v.copy()
    unknown = np.isnan(v).all(axis=0)
    v[:, unknown] = position_difference(log.time, log.q[:, unknown])
    return v
