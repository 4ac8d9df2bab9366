# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Ways in which friction may turn around at a reversal."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.dahl import dahl_path
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.regression.curves.curve import Curve
from sosml_friction.regression.nominal import turn_columns

#: The smoother sign is made of position low-passed at this multiple of the band. Chosen, no
#: measurement.
_WIDER = 3.0


class Reversal(Curve):
    """Add the differences between ways to turn around at a reversal and the fitted one."""

    identifier: ClassVar[str] = 'reversal'
    amplitudes: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ('sooner', 'later', 'smoother'), '{effort}'
    )

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return the differences of the sign."""
        q = signals.band.smooth(signals.q[:, joint : joint + 1], _WIDER)[:, 0]
        scale = float(signals.scales.displacement[joint])
        smoother = dahl_path(np.ascontiguousarray(q), scale) - signals.sign[:, joint]
        return signals.in_joint(joint, *turn_columns(signals, joint).values(), smoother)
