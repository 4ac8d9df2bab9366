# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A gap in the gear."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

from sosml_friction.diagnosis.effect import FloatArray, Inner
from sosml_friction.model.robot import Robot
from sosml_friction.regression.signals import Signals
from sosml_friction.regression.two_mass import (
    Transmission,
    gear_term,
    resonances,
    transmission_column,
)
from sosml_friction.simulation.forward_terms import GearTerm


class Backlash(Transmission):
    """
    Add what a body behind a gap needs more: M d'' + dg/dq d, d the deflection.

    M d'' + c d' + K dead(d, gap) = -tau_load; ``gap`` [rad or m] between the flanks and
    ``stiffness`` K of the mesh, whose resonance is at the edge of the band or above.
    """

    identifier: ClassVar[str] = 'backlash'
    inner: ClassVar[Mapping[str, str]] = {'gap': '{length}', 'stiffness': '{effort}/{length}'}
    refined: ClassVar[tuple[str, ...]] = ('gap',)
    inseparable: ClassVar[tuple[str, ...]] = ('joint_elasticity',)

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return the effort of the deflection."""
        return transmission_column(signals, joint, inner['stiffness'], inner['gap'])

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> GearTerm:
        """Return the gear, that gives ``amplitude`` times as much."""
        return gear_term(joint, inner['stiffness'], inner['gap'], float(amplitude[0]))

    def grid(self, signals: Signals, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        mesh = resonances(signals, joint)[-2:]
        scale = signals.scales.sign_limit[joint]
        gaps = (1.0, 2.5, 6.0, 15.0)
        return [{'gap': float(g * scale), 'stiffness': float(k)} for g in gaps for k in mesh]

    def inner_bounds(self, signals: Signals, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range."""
        scale = float(signals.scales.sign_limit[joint])
        return {'gap': (0.3 * scale, 40.0 * scale)}
