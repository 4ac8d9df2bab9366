# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Samples of a recording beside those of its simulation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.exceptions import DataError

QUANTITIES = ('position', 'velocity', 'effort')


@dataclass(frozen=True)
class RecordedRun:
    """
    Hold N samples of n joints.

    ``time`` (N,) [s] since the first sample of the log; ``measured`` and ``simulated``: position,
    velocity and effort (N, n), NaN where not known; ``begins`` (N,): where the simulation begins
    anew.
    """

    time: FloatArray
    measured: tuple[FloatArray, ...]
    simulated: tuple[FloatArray, ...]
    begins: BoolArray

    @classmethod
    def joined(cls, runs: Sequence[RecordedRun]) -> RecordedRun:
        """Return one run after the other."""
        return cls(
            np.concatenate([run.time for run in runs]),
            tuple(map(np.concatenate, zip(*(run.measured for run in runs), strict=True))),
            tuple(map(np.concatenate, zip(*(run.simulated for run in runs), strict=True))),
            np.concatenate([run.begins for run in runs]),
        )


def begins_every(length: int, count: int) -> BoolArray:
    """Return (count,) that is true at every sample that a piece of ``length`` begins at."""
    return np.arange(count) % length == 0


def refuse_runaway(q: FloatArray, what: str) -> None:
    """
    Refuse a simulation that did not stay where a robot can be.

    :raises DataError: if a position of it is not finite.
    """
    if not np.isfinite(q).all():
        raise DataError(
            f'the simulation of {what} runs away: the model is unstable, or the effort in the '
            'recording has another sign or unit than the model'
        )
