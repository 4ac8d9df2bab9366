# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A spring that slips: a cable, a hose, a belt or a flexspline beside the joint's friction."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.dahl_term import DahlTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner

#: The least x_s in displacements of the sign: as far as presliding friction is tried.
_SHORTEST = 20.0
#: The largest x_s as a share of the range: over twice as much z is within exp(-2) of slipping, and
#: over less of it a spring that slips is hardly more than a spring.
_LONGEST = 0.5
#: x_s that are tried: more than a small grid has (band_rows.SMALL_GRID), all of which are taken
#: for no noise together. Of so many loops some sum explains any rest; one alone does not.
_POINTS = 20
#: Within this share of it the least x_s is the best: rounding of a search by logarithms.
_AT_BOUND = 1e-6


class Hysteresis(DahlTerm):
    """
    Add F z(x_s): a spring of stiffness F / x_s that slips at F.

    z is Dahl's state with ``displacement`` x_s [rad or m]. Where it builds up in another way, F is
    off by up to a quarter.
    """

    identifier: ClassVar[str] = 'hysteresis'
    size_known: ClassVar[bool] = False
    at_reversals: ClassVar[bool] = True
    elsewhere_too: ClassVar[bool] = True

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return z."""
        return (state[:, 0],)

    def applies(self, signals: Recording, joint: int) -> bool:
        """Tell whether the joint moves far enough."""
        shortest, longest = self._range(signals, joint)
        return longest > shortest

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        shortest, longest = self._range(signals, joint)
        return [{'displacement': float(x)} for x in np.geomspace(shortest, longest, _POINTS)]

    def inner_bounds(self, signals: Recording, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range."""
        return {'displacement': self._range(signals, joint)}

    def _range(self, signals: Recording, joint: int) -> tuple[float, float]:
        scales = signals.scales
        return _SHORTEST * float(scales.sign_limit[joint]), _LONGEST * float(scales.span[joint])

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if fit.amplitude[0] <= 0.0:
            return 'it would give energy back that nobody put in'
        if fit.inner['displacement'] <= (1.0 + _AT_BOUND) * self._range(fit.signals, fit.joint)[0]:
            return 'it would slip over less than friction builds up over'
        return ''
