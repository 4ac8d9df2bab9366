# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A cable, a strap or a limb."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.parameter import Z_95
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.term import Inner

#: Least stiffness that counts as seen, in standard errors.
_CLEAR = 4.0
#: Or where its rest position is within this many ranges of the motion from its middle: gravity
#: within its tolerance may make up for the rest of a spring, but what is a constant alone relaxes
#: nowhere.
_REACH = 1.5


class Spring(EffortTerm):
    """Add k (q - q_0) as k q + offset."""

    identifier: ClassVar[str] = 'spring'
    amplitudes: ClassVar[Mapping[str, str]] = {
        'stiffness': '{effort}/{length}',
        'offset': '{effort}',
    }
    held_by: ClassVar[tuple[str, ...]] = ('mjcf', 'sdf')
    axis: ClassVar[str] = 'position'
    trusted_as: ClassVar[str] = 'terms'
    free_axis: ClassVar[str] = 'position'
    worn: ClassVar[bool] = True

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return q and 1."""
        q = motion.q[:, joint]
        return q, np.ones_like(q)

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if fit.amplitude[0] <= 0.0:
            return 'a spring has a positive stiffness'
        if self.stated is None and self.reduces_to(fit):
            return 'no stiffness is seen: what is left of a spring is a constant'
        return ''

    def reduces_to(self, fit: Fitted) -> str:
        """Return 'effort_bias' where no stiffness is seen: what is left is a constant."""
        k, offset = fit.amplitude
        if k >= _CLEAR * fit.error[0]:
            return ''
        q = fit.signals.q[:, fit.joint]
        middle, span = 0.5 * float(q.min() + q.max()), float(np.ptp(q))
        # A stiffer one within the standard error relaxes nearer.
        near = abs(k * middle + offset) < (k + fit.error[0]) * _REACH * span
        return '' if k > 0.0 and near else 'effort_bias'

    def nested(self, fit: Fitted) -> str:
        """Return 'effort_bias' where the interval of a stiffness that nobody states holds 0."""
        seen = fit.amplitude[0] >= Z_95 * fit.error[0]
        return '' if seen or self.stated is not None else 'effort_bias'
