# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Terms of friction that fades with speed, as Stribeck's does."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from copy import copy
from typing import ClassVar, TypeVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.dahl import following_path
from sosml_friction.model.smooth_sign import softened
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
#: The inner parameter of friction that follows its level, and its range, as shares of the
#: displacement over which friction turns around: the bristles are the same. A factor of two to
#: both sides is what that is known to, beside a level that changes within it. Chosen.
FOLLOWS, ABOUT = 'follows', (0.5, 2.0)


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

    ``broad``: it fades as :func:`broad_fade`, which has no exponent. With an inner parameter
    ``follows`` [rad or m] friction follows its level over that displacement, as bristles do: where
    the knee is crossed within it, as after each start, less of S is seen. The bristles are those
    that turn friction around: it is fitted ``about`` their displacement, where the data show it,
    and is in no model.
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
        refined = tuple(name for name in self.refined if name != 'exponent')
        vars(result).update(broad=True, refined=refined)
        return (result,)

    def further(self: _T, displacement: float) -> tuple[_T, Inner] | None:
        """Return the term that follows its level over about that displacement."""
        if self.stated is not None:
            return None
        result = copy(self)
        refined = tuple(dict.fromkeys((*self.refined, FOLLOWS)))
        vars(result).update(refined=refined, about=displacement)
        return result, {FOLLOWS: displacement}

    @abstractmethod
    def at_standstill(self, motion: Motion, joint: int | slice, sign: FloatArray) -> FloatArray:
        """Return the effort per unit of the amplitude where none has faded, (N,), at a sign."""

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return it times exp(-(|q'| / v_s)^d)."""
        own = self._faded(motion.v[:, joint], inner)
        return (self.at_standstill(motion, joint, motion.sign[:, joint] * own),)

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return the effort along a recording, of friction that follows if its inner says so."""
        if FOLLOWS not in inner:
            return super().columns(signals, joint, inner)
        path, v = np.ascontiguousarray(signals.q[:, joint]), signals.v[:, joint]
        state = following_path(path, inner[FOLLOWS], self._faded(v, inner))
        sign = softened(state, v, float(signals.scales.width[joint]))
        return signals.in_joint(joint, self.at_standstill(signals.motion, joint, sign))

    def _faded(self, v: FloatArray, inner: Inner) -> FloatArray:
        v_s = inner['stribeck_velocity']
        return broad_fade(v, v_s) if self.broad else fade(v, v_s, inner['exponent'])

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        top = float(signals.scales.speed[joint])
        return [{'stribeck_velocity': top * share, 'exponent': 1.0} for share in KNEES]

    def inner_bounds(self, signals: Recording, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range."""
        top = float(signals.scales.speed[joint])
        result = {'stribeck_velocity': (0.005 * top, 0.4 * top), 'exponent': EXPONENTS}
        if self.about:
            result[FOLLOWS] = ABOUT[0] * self.about, ABOUT[1] * self.about
        return result
