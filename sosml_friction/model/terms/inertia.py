# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""An inertia about the joint that is not the nominal one."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.body_term import BodyTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.simulated_term import Body
from sosml_friction.model.terms.kinds.term import Inner


class Inertia(BodyTerm):
    """Change the rotor: change * q'' more."""

    identifier: ClassVar[str] = 'inertia'
    amplitudes: ClassVar[Mapping[str, str]] = {'change': '{inertia}'}
    parameter_error: ClassVar[bool] = True
    axis: ClassVar[str] = 'acceleration'

    def changes(self, robot: Robot, joint: int, inner: Inner) -> tuple[Body, ...]:
        """Return one rotor inertia more."""
        body = Body.unchanged(robot.n)
        body.rotors[joint] = 1.0
        return (body,)

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        inertia = fit.signals.robot.inertia(np.median(fit.signals.q, axis=0))
        whole = float(inertia[fit.joint, fit.joint])
        if whole + fit.amplitude[0] < 0.3 * whole:
            return 'hardly any inertia would be left'
        return ''
