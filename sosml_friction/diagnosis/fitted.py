# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a fit found of one cause, as the cause itself is asked about it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from sosml_friction.regression.signals import FloatArray, Signals


@dataclass(frozen=True)
class Fitted:
    """
    Hold the amplitudes of a cause in one joint beside the data that they were fitted to.

    ``inner``: its inner parameters; ``amplitude`` (k,) and its standard errors ``error`` (k,), in
    the order of ``Effect.amplitudes``; NaN where unknown.
    """

    signals: Signals
    joint: int
    inner: Mapping[str, float]
    amplitude: FloatArray
    error: FloatArray
