# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a fit found of one term, as the term itself is asked about it."""

from collections.abc import Mapping
from dataclasses import dataclass

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.recording import Recording


@dataclass(frozen=True)
class Fitted:
    """
    Hold the amplitudes of a term in one joint beside the data that they were fitted to.

    ``inner``: its inner parameters; ``amplitude`` (k,), with what the model states of it, and its
    standard errors ``error`` (k,), in the order of ``Term.amplitudes``; ``inner_error``: those of
    inner parameters that were fitted; NaN where unknown.
    """

    signals: Recording
    joint: int
    inner: Mapping[str, float]
    amplitude: FloatArray
    error: FloatArray
    inner_error: Mapping[str, float] | None = None
