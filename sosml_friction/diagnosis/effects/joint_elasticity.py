# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A gear or shaft that gives."""

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


class JointElasticity(Transmission):
    """
    Add what a body behind a spring needs more: M d'' + dg/dq d, d the deflection.

    M d'' + c d' + K d = -tau_load, K = ``stiffness``; sqrt(K / M) may be in the band.
    """

    identifier: ClassVar[str] = 'joint_elasticity'
    inner: ClassVar[Mapping[str, str]] = {'stiffness': '{effort}/{length}'}
    refined: ClassVar[tuple[str, ...]] = ('stiffness',)
    inseparable: ClassVar[tuple[str, ...]] = ('backlash',)

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return the effort of the deflection."""
        return transmission_column(signals, joint, inner['stiffness'], 0.0)

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> GearTerm:
        """Return the gear, that gives ``amplitude`` times as much."""
        return gear_term(joint, inner['stiffness'], 0.0, float(amplitude[0]))

    def grid(self, signals: Signals, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        return [{'stiffness': float(k)} for k in resonances(signals, joint)]

    def inner_bounds(self, signals: Signals, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range."""
        found = resonances(signals, joint)
        return {'stiffness': (0.5 * float(found[0]), 2.0 * float(found[-1]))}
