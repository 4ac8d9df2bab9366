# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The profile likelihood with the best fit among its points."""

from collections.abc import Mapping

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.law.law_profile import LawProfile


def with_best(
    profile: LawProfile, drawn: Mapping[str, float]
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return v_s, excess, S and half range of a profile with the best fit among its points."""
    v, excess, s, half = (
        profile.stribeck_velocity, profile.excess, profile.stribeck, profile.half,
    )  # fmt: skip
    v_s, size = drawn.get('stribeck_velocity', np.nan), drawn.get('stribeck', np.nan)
    if not np.isfinite([v_s, size]).all() or np.isclose(v, v_s, rtol=1e-9, atol=0.0).any():
        return v, excess, s, half
    k = int(np.searchsorted(v, v_s))
    near = half[min(k, len(half) - 1)]
    return (
        np.insert(v, k, v_s),
        np.insert(excess, k, 0.0),
        np.insert(s, k, size),
        np.insert(half, k, near),
    )
