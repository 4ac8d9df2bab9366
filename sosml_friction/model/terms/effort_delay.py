# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort that is late, or early, beside position."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.finite_differences import first_derivative
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.simulated_term import SimulatedTerm
from sosml_friction.model.terms.kinds.term import Inner, Term

#: Largest delay [s]: a loop with a longer one would be seen to be late. Chosen, no measurement.
LARGEST_S = 0.05


def effort_slope(signals: Recording) -> FloatArray:
    """
    Return the slope of the nominal effort in time, (N, n) [Nm/s or N/s].

    Over the whole band: smoothed to half of it, an effort that changed faster came out as late as
    twice its delay.
    """
    return first_derivative(signals.rigid + signals.friction, signals.band.step)


class EffortDelay(Term):
    """Add -d dtau/dt: effort comes a ``delay`` d [s] after position."""

    identifier: ClassVar[str] = 'effort_delay'
    amplitudes: ClassVar[Mapping[str, str]] = {'delay': 's'}
    of_robot: ClassVar[bool] = True
    axis: ClassVar[str] = 'effort'
    left_out: ClassVar[str] = (
        'the effort belongs to an earlier position, which shows as viscous friction where gravity '
        'changes: mend it in the driver'
    )

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return -dtau/dt."""
        return -effort_slope(signals)[:, :, None]

    def simulated(
        self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray
    ) -> SimulatedTerm:
        """Return a report that is late."""
        late = SimulatedTerm()
        acts = np.arange(robot.n) == joint
        late.delay = np.where(acts | self.of_robot, amplitude[0], 0.0)
        return late

    def tolerated(self, fit: Fitted, tolerance: float) -> bool:
        """
        Tell whether effort is early by less than a sampling interval, as of a held command.

        From its stamp a command is computed, sent, and held to the next: it acts half an interval
        later, and by what the computer takes, which no model tells.
        """
        return bool(-fit.signals.band.step < self.change(fit)[0] < 0.0)

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if abs(fit.amplitude[0]) > LARGEST_S:
            return f'a delay of over {1e3 * LARGEST_S:.0f} ms would be seen'
        return ''


class JointEffortDelay(EffortDelay):
    """Add -d dtau/dt in one joint: its drive filters or reports in another way than the others."""

    of_robot: ClassVar[bool] = False

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return -dtau/dt of the joint."""
        return signals.in_joint(joint, -effort_slope(signals)[:, joint])


EffortDelay.counterpart = JointEffortDelay
