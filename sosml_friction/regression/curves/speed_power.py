# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One power of speed."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.model.terms.nonlinear_viscous import POWERS, power_of_speed
from sosml_friction.regression.curves.curve import Curve


class SpeedPower(Curve):
    """Add s |q'|^p: friction by speed that is neither Coulomb's nor viscous, in one term."""

    identifier: ClassVar[str] = 'power_of_speed'
    amplitudes: ClassVar[Mapping[str, str]] = {'level': '{effort}'}
    inner: ClassVar[Mapping[str, str]] = {'power': '1'}

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return powers well away from 0 and 1, which have names."""
        return [{'power': p} for p in POWERS]

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return s (|q'| / top speed)^p."""
        speed = signals.v[:, joint] / float(signals.scales.speed[joint])
        column = signals.sign[:, joint] * power_of_speed(speed, inner['power'])
        return signals.in_joint(joint, column)
