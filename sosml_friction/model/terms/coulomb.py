# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Coulomb friction."""

from collections.abc import Mapping
from typing import ClassVar

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.law_constant import LawConstant
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.term import Inner


class Coulomb(LawConstant):
    """Add C s: a level that opposes motion, s the sign of motion."""

    identifier: ClassVar[str] = 'coulomb'
    called: ClassVar[str] = 'Coulomb friction'
    amplitudes: ClassVar[Mapping[str, str]] = {'coulomb': '{effort}'}
    reported_as: ClassVar[Mapping[str, str]] = {'coulomb': 'change'}

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return s."""
        return (motion.sign[:, joint],)
