# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Viscous friction."""

from collections.abc import Mapping
from typing import ClassVar

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.law_constant import LawConstant
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.term import Inner


class Viscous(LawConstant):
    """Add B q'."""

    identifier: ClassVar[str] = 'viscous'
    called: ClassVar[str] = 'viscous friction'
    amplitudes: ClassVar[Mapping[str, str]] = {'viscous': '{effort} s/{length}'}
    reported_as: ClassVar[Mapping[str, str]] = {'viscous': 'change'}

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return q'."""
        return (motion.v[:, joint],)
