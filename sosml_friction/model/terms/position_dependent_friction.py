# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that follows posture."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner

#: Most periods in the range of motion: what repeats more often is a ripple, and no posture.
_PERIODS = 3


class PositionDependentFriction(EffortTerm):
    """
    Add s (A cos w q + B sin w q): friction with w periods per rad or m, its sign by direction.

    ``frequency`` w [rad/rad or rad/m]: 1 and 2 per turn, as of an eccentric wheel; along a slide
    any from half a period to three in the range of motion, of which a few make any course.
    """

    identifier: ClassVar[str] = 'position_dependent_friction'
    amplitudes: ClassVar[Mapping[str, str]] = {'cosine': '{effort}', 'sine': '{effort}'}
    inner: ClassVar[Mapping[str, str]] = {'frequency': 'rad/{length}'}
    refined: ClassVar[tuple[str, ...]] = ('frequency',)
    axis: ClassVar[str] = 'position'
    free_axis: ClassVar[str] = 'position'
    repeats: ClassVar[bool] = True

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return s cos w q and s sin w q."""
        angle = inner['frequency'] * motion.q[:, joint]
        s = motion.sign[:, joint]
        return s * np.cos(angle), s * np.sin(angle)

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        # More of them leave a UR10e with twice its effort: the noise is what no column explains.
        if signals.length_unit(joint) == 'rad':
            return ({'frequency': 1.0}, {'frequency': 2.0})
        half, _ = self.inner_bounds(signals, joint)['frequency']
        return tuple({'frequency': k * half} for k in range(1, 2 * _PERIODS + 1))

    def inner_bounds(self, signals: Recording, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the ends of its grid along a slide; a turn is known."""
        if signals.length_unit(joint) == 'rad':
            return {}
        half = np.pi / float(signals.scales.span[joint])
        return {'frequency': (half, 2 * _PERIODS * half)}

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if float(np.hypot(*fit.amplitude)) > 1.5 * fit.signals.scales.level(fit.joint):
            return 'friction would be negative in some posture'
        return ''
