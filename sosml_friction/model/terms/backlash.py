# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A gap in the gear."""

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


class Backlash(TransmissionTerm):
    """
    Add what a body behind a gap needs more: M d'' + dg/dq d, d the deflection.

    M d'' + c d' + K dead(d, gap) = -tau_load; ``gap`` [rad or m] between the flanks and
    ``stiffness`` K of the mesh, whose resonance is at the edge of the band or above.
    """

    identifier: ClassVar[str] = 'backlash'
    inner: ClassVar[Mapping[str, str]] = {'gap': '{length}', 'stiffness': '{effort}/{length}'}
    refined: ClassVar[tuple[str, ...]] = ('gap',)
    inseparable: ClassVar[tuple[str, ...]] = ('joint_elasticity',)
    told_apart: ClassVar[Mapping[str, tuple[str, str]]] = {
        'joint_elasticity': (
            '',
            'lock the motor and move the link by hand, or measure the link: with position at the '
            'motor alone a gap and a spring look alike',
        )
    }

    def gear(self, joint: int, inner: Inner) -> Gear:
        """Return the gear."""
        return gear_of(joint, inner['stiffness'], inner['gap'])

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        mesh = resonances(signals, joint)[-2:]
        scale = signals.scales.sign_limit[joint]
        gaps = (1.0, 2.5, 6.0, 15.0)
        return [{'gap': float(g * scale), 'stiffness': float(k)} for g in gaps for k in mesh]

    def inner_bounds(self, signals: Recording, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range."""
        scale = float(signals.scales.sign_limit[joint])
        return {'gap': (0.3 * scale, 40.0 * scale)}
