# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that changes as the gear warms up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.exceptions import DataError
from sosml_friction.model.robot import Robot
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_term import Motion
from sosml_friction.simulation.forward_terms import LoadTerm

#: No gear warms up faster than this [s]; a shorter time would be a start, not a drift.
_FASTEST = 60.0
#: No gear gets warmer by more than this [K]: how much friction a simulation has to be ready for.
_WARMEST = 50.0
#: Without a temperature, a recording has to be so long to show a drift: in less, what differs from
#: one part of the trajectory to the next looks the same [s].
_SHORTEST = 200.0


class ThermalDrift(Effect):
    """
    Add (1 - exp(-t / T)) (a q' + b s); with a temperature, (theta - theta_0) (a q' + b s).

    ``time_constant`` T [s], 0 where temperature is measured (a and b are then per degC).
    """

    identifier: ClassVar[str] = 'thermal_drift'
    amplitudes: ClassVar[Mapping[str, str]] = {
        'viscous_drift': '{effort} s/{length}',
        'coulomb_drift': '{effort}',
    }
    inner: ClassVar[Mapping[str, str]] = {'time_constant': 's'}
    refined: ClassVar[tuple[str, ...]] = ('time_constant',)

    def applies(self, signals: Signals, joint: int) -> bool:
        """Tell whether the recording is long enough to see a drift, or temperature is known."""
        return float(signals.time[-1]) > _SHORTEST or self._measured(signals, joint)

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return the warming times q' and s."""
        if inner['time_constant'] == 0.0 and signals.temperature is not None:
            warm = signals.temperature[:, joint] - signals.temperature[0, joint]
        else:
            warm = 1.0 - np.exp(-signals.time / max(inner['time_constant'], 1e-9))
        return signals.in_joint(joint, warm * signals.v[:, joint], warm * signals.sign[:, joint])

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> LoadTerm:
        """Return the warming times a q' + b s, by time or by measured temperature."""
        viscous, coulomb = float(amplitude[0]), float(amplitude[1])
        time_constant = inner['time_constant']

        def load(motion: Motion) -> FloatArray:
            warm = motion.warm[:, joint]
            if time_constant != 0.0:
                warm = 1.0 - np.exp(-motion.time / time_constant)
            elif not np.isfinite(warm).all():
                raise DataError(
                    f'the friction of {robot.names[joint]} follows its temperature, which the '
                    'recording does not have: record joint_temperatures'
                )
            by_speed, by_sign = viscous * motion.v[:, joint], coulomb * motion.sign[:, joint]
            return np.asarray(warm * (by_speed + by_sign))

        return LoadTerm(joint, load, coulomb * (1.0 if time_constant else _WARMEST))

    def units(self, signals: Signals, joint: int) -> dict[str, str]:
        """Return the units: of a drift per degC where temperature is measured."""
        units = super().units(signals, joint)
        per = '/degC' if self._measured(signals, joint) else ''
        return {**units, **{name: units[name] + per for name in self.amplitudes}}

    def grid(self, signals: Signals, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        if self._measured(signals, joint):
            return ({'time_constant': 0.0},)
        whole = float(signals.time[-1])
        return [{'time_constant': max(_FASTEST, whole * share)} for share in (0.4, 0.8, 1.6)]

    def inner_bounds(self, signals: Signals, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range."""
        if self._measured(signals, joint):
            return {}
        return {'time_constant': (_FASTEST, 4.0 * float(signals.time[-1]))}

    @staticmethod
    def _measured(signals: Signals, joint: int) -> bool:
        """Tell whether temperature is known throughout, and changes by more than 2 degC."""
        if signals.temperature is None:
            return False
        values = signals.temperature[:, joint]
        return bool(np.isfinite(values).all() and np.ptp(values) > 2.0)
