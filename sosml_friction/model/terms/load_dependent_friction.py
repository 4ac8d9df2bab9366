# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that grows with load."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.term import Inner

_LOAD = 'repeat the recording with a known payload: friction that follows the load grows'


class LoadDependentFriction(EffortTerm):
    """Add k |tau_load| s, tau_load what the gear passes on, k = ``load_coefficient``."""

    identifier: ClassVar[str] = 'load_dependent_friction'
    amplitudes: ClassVar[Mapping[str, str]] = {'load_coefficient': '1'}
    axis: ClassVar[str] = 'load'
    told_apart: ClassVar[Mapping[str, tuple[str, str]]] = {
        'position_dependent_friction': (
            'known_payload',
            f'{_LOAD}, friction that follows posture does not',
        ),
        'coulomb': ('known_payload', _LOAD),
    }

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return |tau_load| s."""
        return (np.abs(motion.load[:, joint]) * motion.sign[:, joint],)

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if not 0.0 < fit.amplitude[0] < 0.5:
            return 'a gear loses between nothing and half of its load'
        return ''
