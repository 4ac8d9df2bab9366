# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One time for all joints, unless one of them has another."""

from collections.abc import Mapping, Sequence
from typing import TypeVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.term import ALL_JOINTS
from sosml_friction.regression.rival import VERY_STRONG

_T = TypeVar('_T')


def shared_time(
    times: FloatArray, precision: FloatArray, sooner: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """
    Return the mean of times (n,) for each joint and its precision (n,), or them as they are.

    All joints together tell it better than each by itself. Drives of several kinds have times of
    their own: then one of them very strongly differs from the mean of the others, by
    (t - m)^2 > c (1 / p + 1 / p_m).

    :param precision: 1 / variance (n,); 0: not known.
    :param sooner: by how much the effort of each was taken sooner before (n,) [s]: joints that
        differ in that are late by times of their own. None for all alike.
    """
    groups = [] if sooner is None else np.unique(sooner).tolist()
    if len(groups) > 1:
        result = np.array(times), np.array(precision)
        for each in groups:
            own = sooner == each
            result[0][own], result[1][own] = shared_time(times[own], precision[own])
        return result
    total, weighted = precision.sum(), precision * times
    others, mean = total - precision, weighted.sum() - weighted
    known = (precision > 0.0) & (others > 0.0)
    p, rest = precision[known], others[known]
    apart = (times[known] - mean[known] / rest) ** 2 > VERY_STRONG * (1.0 / p + 1.0 / rest)
    if apart.any() or not total > 0.0:
        return times, precision
    return np.full_like(times, weighted.sum() / total), np.full_like(times, total)


def precision_of(errors: FloatArray) -> FloatArray:
    """Return one over the variance of standard errors (n,), 0 where one is not known."""
    known = np.isfinite(errors) & (errors > 0.0)
    return np.power(errors, -2.0, where=known, out=np.zeros_like(errors))


def told_once(by_joint: Mapping[str, _T], names: Sequence[str]) -> Mapping[str, _T]:
    """Return what is said of joints under ``*`` where it is the same of all ``names``."""
    first = next(iter(by_joint.values()), None)
    if first is None or len(by_joint) < len(names) or any(x != first for x in by_joint.values()):
        return by_joint
    return {ALL_JOINTS: first}
