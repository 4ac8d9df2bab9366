# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Any friction by speed."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.regression.curves.curve import Curve
from sosml_friction.regression.curves.knots import padded_hats

_HATS = 6
#: Lowest knot of speed, as a share of the top speed: below it is the turning around.
_SLOWEST = 0.04


class SpeedCurve(Curve):
    """Add s f(|q'|) with any piecewise linear f: what friction by speed could explain at most."""

    identifier: ClassVar[str] = 'speed'
    amplitudes: ClassVar[Mapping[str, str]] = {f'hat_{k}': '{effort}' for k in range(_HATS)}

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return s times hat functions on knots of |q'| in geometric steps."""
        knots = float(signals.scales.speed[joint]) * np.geomspace(_SLOWEST, 1.0, _HATS)
        s = signals.sign[:, joint]
        curves = padded_hats(np.abs(signals.v[:, joint]), knots, _HATS, (s,))
        return signals.in_joint(joint, *curves.T)
