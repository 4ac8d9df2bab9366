# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that grows with a power of speed."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner

#: Powers of speed that are neither Coulomb friction, 0, nor viscous, 1.
POWERS = (0.3, 0.5, 0.7, 1.4, 2.0, 3.0)


def power_of_speed(v: FloatArray, power: float) -> FloatArray:
    """Return |v|^p: the one place where this is written."""
    return np.asarray(np.abs(v) ** power)


def power_columns(v: FloatArray, power: float) -> tuple[FloatArray, FloatArray]:
    """Return s |v|^p and its derivative by p, s |v|^p ln |v|, 0 at standstill."""
    drag = np.sign(v) * power_of_speed(v, power)
    return drag, drag * np.log(np.where(v != 0.0, np.abs(v), 1.0))


class NonlinearViscous(EffortTerm):
    """
    Add P s |q'|^p: friction of lubricants and gears that bends with speed, or drag.

    P = ``nonlinear_viscous``, its effort at unit speed, p = ``power``. A diagnosis says
    that there is such a bend, not which law it has; a fit asks for this one.
    """

    identifier: ClassVar[str] = 'nonlinear_viscous'
    amplitudes: ClassVar[Mapping[str, str]] = {'nonlinear_viscous': '{effort}'}
    inner: ClassVar[Mapping[str, str]] = {'power': '1'}
    refined: ClassVar[tuple[str, ...]] = ('power',)
    searched: ClassVar[bool] = False
    of_law: ClassVar[bool] = True
    axis: ClassVar[str] = 'speed'
    free_axis: ClassVar[str] = 'speed'
    one_power: ClassVar[bool] = True

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return s |q'|^p."""
        return (motion.sign[:, joint] * power_of_speed(motion.v[:, joint], inner['power']),)

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        return [{'power': power} for power in POWERS]

    def inner_bounds(self, signals: Recording, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the range of published powers."""
        return {'power': (POWERS[0], POWERS[-1])}
