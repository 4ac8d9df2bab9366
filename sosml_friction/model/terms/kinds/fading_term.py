# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Terms of friction that fades with speed, as Stribeck's does."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from copy import copy
from typing import ClassVar, TypeVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner

_T = TypeVar('_T', bound='FadingTerm')

#: Range of the exponent: from 0.5 (Bo and Pavelescu 1982, who found 0.5 to 1) to above that of the
#: Gaussian, 2 (Armstrong-Helouvry, Dupont and Canudas de Wit 1994).
EXPONENTS = (0.5, 2.5)
#: Values of v_s that are tried first, as shares of the top speed. Chosen, no measurement.
KNEES = tuple(np.geomspace(0.01, 0.25, 7).tolist())


def fade(
    v: FloatArray | float, stribeck_velocity: FloatArray | float, exponent: FloatArray | float
) -> FloatArray:
    """
    Return exp(-(|v| / v_s)^d): the one place where this is written.

    Of numbers or arrays that broadcast, all dimensions [rad/s or m/s] but for d; plain enough to
    be compiled where a loop needs it.
    """
    result: FloatArray = np.exp(-((np.abs(v) / stribeck_velocity) ** exponent))
    return result


def broad_fade(v: FloatArray, stribeck_velocity: float) -> FloatArray:
    """
    Return 1 / (1 + (v / v_s)^2), which falls later than any exponential of |v| / v_s.

    D. P. Hess, A. Soom, Journal of Tribology 112, 1990; it is in the model of seven parameters of
    Armstrong-Helouvry, Dupont and Canudas de Wit 1994.
    """
    return np.asarray(1.0 / (1.0 + (v / stribeck_velocity) ** 2))


def fade_slopes(
    v: FloatArray, stribeck_velocity: float, exponent: float
) -> tuple[FloatArray, ...]:
    """
    Return the derivatives of :func:`fade` by v_s and by d.

    f d x^d / v_s and -f x^d ln x, with x = |v| / v_s and f the fade; both 0 at rest.
    """
    x = np.abs(v) / stribeck_velocity
    own = fade(v, stribeck_velocity, exponent) * x**exponent
    return own * exponent / stribeck_velocity, -own * np.log(np.maximum(x, np.finfo(float).tiny))


class FadingTerm(EffortTerm):
    """
    State friction at standstill, which fades by ``stribeck_velocity`` and ``exponent``.

    ``broad``: it fades as :func:`broad_fade`, which has no exponent.
    """

    inner: ClassVar[Mapping[str, str]] = {'stribeck_velocity': '{length}/s', 'exponent': '1'}
    refined: ClassVar[tuple[str, ...]] = ('stribeck_velocity', 'exponent')
    broad: bool = False

    def rivals(self: _T) -> tuple[_T, ...]:
        """Return the term that fades as :func:`broad_fade`."""
        if self.stated is not None:
            # Its inner parameters stay.
            return ()
        result = copy(self)
        vars(result).update(broad=True, refined=('stribeck_velocity',))
        return (result,)

    @abstractmethod
    def at_standstill(self, motion: Motion, joint: int | slice) -> FloatArray:
        """Return the effort per unit of the amplitude where none has faded, (N,)."""

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return it times exp(-(|q'| / v_s)^d)."""
        v, v_s = motion.v[:, joint], inner['stribeck_velocity']
        own = broad_fade(v, v_s) if self.broad else fade(v, v_s, inner['exponent'])
        return (self.at_standstill(motion, joint) * own,)

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        top = float(signals.scales.speed[joint])
        return [{'stribeck_velocity': top * share, 'exponent': 1.0} for share in KNEES]

    def inner_bounds(self, signals: Recording, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range."""
        top = float(signals.scales.speed[joint])
        return {'stribeck_velocity': (0.005 * top, 0.4 * top), 'exponent': EXPONENTS}
