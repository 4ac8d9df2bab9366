# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A constant in the measured effort."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import (
    Effect,
    FloatArray,
    Inner,
    effort_unit,
    in_joint,
)
from sosml_friction.diagnosis.signals import Signals


class EffortBias(Effect):
    """Add bias: an offset of the current sensor."""

    identifier: ClassVar[str] = 'effort_bias'
    amplitudes: ClassVar[tuple[str, ...]] = ('bias',)
    parameter_error: ClassVar[bool] = True
    twins: ClassVar[tuple[str, ...]] = ('asymmetric_friction',)

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return 1."""
        return in_joint(signals, joint, np.ones(len(signals.q)))

    def units(self, signals: Signals, joint: int) -> Mapping[str, str]:
        """Return the units."""
        return {'bias': effort_unit(signals, joint)}

    def applies(self, signals: Signals, joint: int) -> bool:
        """Tell whether the model knows of a bias, or of none."""
        return bool(np.isfinite(signals.scales.bias[joint]))
