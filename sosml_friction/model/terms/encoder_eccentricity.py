# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""An encoder that is off its centre."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.encoder_term import EncoderTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner


class EncoderEccentricity(EncoderTerm):
    """Add tau(q + e) - tau(q), e = A cos q + B sin q: position is wrong once per turn."""

    identifier: ClassVar[str] = 'encoder_eccentricity'
    amplitudes: ClassVar[Mapping[str, str]] = {'cosine': 'rad', 'sine': 'rad'}
    axis: ClassVar[str] = 'position'
    free_axis: ClassVar[str] = 'position'
    left_out: ClassVar[str] = 'the position is wrong once per turn: mend it in the driver'

    def error(self, q: FloatArray, inner: Inner) -> tuple[FloatArray, ...]:
        """Return cos q and sin q."""
        return np.cos(q), np.sin(q)

    def applies(self, signals: Recording, joint: int) -> bool:
        """Tell whether the joint turns."""
        return signals.length_unit(joint) == 'rad'

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if float(np.hypot(*fit.amplitude)) > 0.03:
            return 'an eccentricity of over 30 mrad would be seen'
        return ''
