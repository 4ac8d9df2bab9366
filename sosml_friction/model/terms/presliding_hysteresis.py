# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that builds up with displacement: Dahl."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.parameter import Z_95
from sosml_friction.model.terms.kinds.dahl_term import DahlTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner

#: F as a share of Coulomb friction; it is more only where friction still grows as the joint moves
#: on after a reversal, (C - F) / x_0 + F / x_s > 0.
_LEAST, _MOST = 0.4, 2.0


class PreslidingHysteresis(DahlTerm):
    """
    Add F (z(x_s) - s): friction of level F follows the displacement over x_s, not the sign.

    z is Dahl's state with ``displacement`` x_s [rad or m]; s the one of the nominal model.
    """

    identifier: ClassVar[str] = 'presliding_hysteresis'
    size_known: ClassVar[bool] = False
    at_reversals: ClassVar[bool] = True
    reversals_alone: ClassVar[bool] = True
    free_axis: ClassVar[str] = 'speed'

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return z - s."""
        return (state[:, 0] - motion.sign[:, joint],)

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        smallest = float(signals.scales.sign_limit[joint])
        return [{'displacement': smallest * k} for k in (1.2, 2.0, 3.2, 5.0, 8.0, 13.0, 20.0)]

    def inner_bounds(self, signals: Recording, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range."""
        smallest = float(signals.scales.sign_limit[joint])
        return {'displacement': (smallest, 40.0 * smallest)}

    def tolerated(self, fit: Fitted, tolerance: float) -> bool:
        """
        Tell whether x_s may be x_0, that of s: the term is nothing then, as z is s.

        Friction turns around in another way, which is no cause: a joint that sticks does so, each
        time for another time, and data tell no displacement of it.
        """
        x_0 = float(fit.signals.scales.displacement[fit.joint])
        error = (fit.inner_error or {}).get('displacement', 0.0)
        return bool(float(fit.inner['displacement']) - Z_95 * error < x_0)

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        level, coulomb = fit.amplitude[0], float(fit.signals.scales.coulomb[fit.joint])
        if level <= 0.0:
            return 'the level of friction would be negative'
        # The nominal may take a part of it, or make up for a part that is too much. Where x_s is
        # near x_0, that of s, F (z - s) is F (x_s - x_0) dz/dx_0: F and x_s stand for each other.
        x_0 = float(fit.signals.scales.displacement[fit.joint])
        x_s = float(fit.inner['displacement'])
        most = max(_MOST, 1.0 / (1.0 - x_0 / x_s)) if x_s > x_0 else np.inf
        if coulomb == 0.0:
            return 'the model has no Coulomb friction that builds up'
        if np.isfinite(coulomb) and not _LEAST * coulomb < level < most * coulomb:
            return (
                f'{level / coulomb:.2f} of Coulomb friction would build up, where all of it does'
            )
        return ''
