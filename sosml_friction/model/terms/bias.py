# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""An offset that a friction law has."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.term import Inner


class Bias(EffortTerm):
    """
    Add a constant: what the joint spends at every speed and in both directions alike.

    It is an offset of gravity or of the current, which a law takes up, and no friction. A
    diagnosis looks for these by their own names.
    """

    identifier: ClassVar[str] = 'bias'
    amplitudes: ClassVar[Mapping[str, str]] = {'bias': '{effort}'}
    searched: ClassVar[bool] = False
    of_law: ClassVar[bool] = True
    inseparable: ClassVar[tuple[str, ...]] = ('effort_bias',)

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return 1."""
        return (np.ones_like(motion.v[:, joint]),)
