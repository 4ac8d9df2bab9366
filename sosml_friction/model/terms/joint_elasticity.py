# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A gear that is a spring."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.simulated_term import Gear
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.model.terms.kinds.transmission_term import (
    TransmissionTerm,
    gear_of,
    resonances,
)


class JointElasticity(TransmissionTerm):
    """
    Add what a body behind a spring needs more: M d'' + dg/dq d, d the deflection.

    M d'' + c d' + K d = -tau_load, K = ``stiffness``; sqrt(K / M) may be in the band.
    """

    identifier: ClassVar[str] = 'joint_elasticity'
    inner: ClassVar[Mapping[str, str]] = {'stiffness': '{effort}/{length}'}
    refined: ClassVar[tuple[str, ...]] = ('stiffness',)
    inseparable: ClassVar[tuple[str, ...]] = ('backlash',)
    # It gives wherever its load changes; what friction does as a joint turns around looks alike.
    elsewhere_too: ClassVar[bool] = True

    def gear(self, joint: int, inner: Inner) -> Gear:
        """Return the gear."""
        return gear_of(joint, inner['stiffness'], 0.0)

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        return [{'stiffness': float(k)} for k in resonances(signals, joint)]

    def inner_bounds(self, signals: Recording, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range."""
        found = resonances(signals, joint)
        return {'stiffness': (0.5 * float(found[0]), 2.0 * float(found[-1]))}
