# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the figure of a simulation draws."""

from typing import NamedTuple

from sosml_friction.simulation.recorded.recorded_simulation import RecordedSimulation


class SimulatedJoint(NamedTuple):
    """Hold a simulation, and the number of the joint that is drawn."""

    found: RecordedSimulation
    i: int

    @property
    def name(self) -> str:
        """Return the name of the joint."""
        return self.found.names[self.i]
