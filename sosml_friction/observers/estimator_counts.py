# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How many samples an estimator was given, and what was wrong with them."""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class EstimatorCounts:
    """Count what happened to samples; ``without_effort`` by joint, of those that lacked any."""

    samples: int
    repeated_stamps: int
    time_backwards: int
    gaps: int
    not_finite: int
    without_effort: Mapping[str, int]
