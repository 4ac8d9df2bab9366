# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One frequency of time."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.regression.curves.curve import Curve


class ToneOfTime(Curve):
    """Add A cos 2 pi f t + B sin 2 pi f t: an effort that follows time, whatever the motion."""

    identifier: ClassVar[str] = 'tone_of_time'
    amplitudes: ClassVar[Mapping[str, str]] = {'cosine': '{effort}', 'sine': '{effort}'}
    inner: ClassVar[Mapping[str, str]] = {'hertz': 'Hz'}

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return cos 2 pi f t and sin 2 pi f t."""
        angle = 2.0 * np.pi * float(inner['hertz']) * signals.time
        return signals.in_joint(joint, np.cos(angle), np.sin(angle))
