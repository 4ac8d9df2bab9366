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

#: The least x_s as a share of the range, and not less than ``sign_limit``, which the data resolve.
#: Begun where friction builds up instead, it is named for friction that lags in time, in 2 of 2
#: trials of ``python -m validation.mujoco_campaign --seeds 1 --seed 20261330 --nulls 0 --outside
#: 2``.
_SHORTEST = 0.008
#: The largest x_s as a share of the range: through all of it z goes from -1 to 1 - 2 exp(-2), or
#: 0.73. A spring that slips over more is hardly told from one that does not.
_LONGEST = 0.5
#: How many x_s are tried: more than a small grid has (band_rows.SMALL_GRID). The points of a small
#: one are fitted all together where the noise is measured, and some sum of so many loops explains
#: any rest.
_POINTS = 20
#: A search by logarithms ends as near to the least x_s as this share of it: rounding.
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
        span, least = (float(x[joint]) for x in (signals.scales.span, signals.scales.sign_limit))
        return max(_SHORTEST * span, least), _LONGEST * span

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if fit.amplitude[0] <= 0.0:
            return 'it would give energy back that nobody put in'
        if fit.inner['displacement'] <= (1.0 + _AT_BOUND) * self._range(fit.signals, fit.joint)[0]:
            return 'it would slip over less than friction builds up over'
        return ''
