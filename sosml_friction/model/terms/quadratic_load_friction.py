# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that grows with the square of load."""

from collections.abc import Mapping
from typing import ClassVar

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.term import Inner


class QuadraticLoadFriction(EffortTerm):
    """Add k tau_load^2 s, tau_load the gear's load, k = ``quadratic_load_coefficient``."""

    identifier: ClassVar[str] = 'quadratic_load_friction'
    amplitudes: ClassVar[Mapping[str, str]] = {'quadratic_load_coefficient': '1/{effort}'}
    axis: ClassVar[str] = 'load'
    searched: ClassVar[bool] = False

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return tau_load^2 s."""
        return (motion.load[:, joint] ** 2 * motion.sign[:, joint],)
