# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort in another scale than the torque: a wrong torque constant."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.measurement_term import MeasurementTerm
from sosml_friction.model.terms.kinds.term import Inner

#: The largest error of an effort that is looked for as a cause.
LARGEST = 0.5
_MASS = 'hang a known mass on the arm and record again: a wrong torque constant scales it'


class EffortScale(MeasurementTerm):
    """Add error * tau: the torque constant, or gear ratio, of the effort is wrong."""

    identifier: ClassVar[str] = 'effort_scale'
    amplitudes: ClassVar[Mapping[str, str]] = {'error': '1'}
    parameter_error: ClassVar[bool] = True
    told_apart: ClassVar[Mapping[str, tuple[str, str]]] = {
        'gravity': ('known_payload', f'{_MASS}, a wrong first moment does not'),
        'payload': ('known_payload', f'{_MASS} too'),
        'inertia': ('known_payload', f'{_MASS}, a wrong inertia does not'),
    }

    def excess(
        self, torque: NDArray[np.inexact], joint: int | slice, inner: Inner
    ) -> tuple[NDArray[np.inexact], ...]:
        """Return tau."""
        return (torque[..., joint],)

    def tolerated(self, fit: Fitted, tolerance: float) -> bool:
        """Tell whether a torque constant that is off by its tolerance may have such an error."""
        return bool(abs(self.change(fit)[0]) < tolerance)

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if abs(fit.amplitude[0]) > LARGEST:
            return 'the effort would be wrong by more than half'
        return ''


class CommonEffortScale(EffortScale):
    """
    Add error * tau in all joints, the same error: one wrong unit, or motors of one kind.

    tau is linear in masses, inertias, rotors and friction: all of them off by the same share are
    the same effort along any motion. Only a mass that is known tells the two apart.
    """

    of_robot: ClassVar[bool] = True
    inseparable: ClassVar[tuple[str, ...]] = ('gravity', 'inertia')


EffortScale.counterpart = CommonEffortScale
