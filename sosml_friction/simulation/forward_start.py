# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The measured state that a simulation starts from."""

from dataclasses import dataclass

from sosml_friction.arrays import FloatArray, IndexArray


@dataclass(frozen=True)
class Start:
    """
    Hold the measured state that windows start from, (W, n): of the encoders.

    ``acceleration`` makes the first guess of the load; ``sign`` is the state of friction.
    ``path`` (N, n): measured position of the recording, as smooth as its second derivative needs;
    ``at`` (W,): where in it they start. ``time`` (N,) [s] and ``warm`` (N, n) [degC, NaN]: of the
    recording's samples.
    """

    q: FloatArray
    v: FloatArray
    acceleration: FloatArray
    sign: FloatArray
    path: FloatArray
    at: IndexArray
    time: FloatArray
    warm: FloatArray
