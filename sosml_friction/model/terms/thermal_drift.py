# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that changes as the joint warms up."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import DataError
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner

#: No gear warms up faster than this [s]; a shorter time would be a start, not a drift.
_FASTEST = 60.0
#: Without a temperature, shortest recording that shows a drift: in less, what differs from one
#: part of the trajectory to the next looks the same [s].
_SHORTEST = 200.0


class ThermalDrift(EffortTerm):
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
    needs: ClassVar[str] = f'recordings of more than {_SHORTEST:g} s or temperatures'
    axis: ClassVar[str] = 'time'
    free_axis: ClassVar[str] = 'speed'

    def applies(self, signals: Recording, joint: int) -> bool:
        """Tell whether the recording is long enough to see a drift, or temperature is known."""
        return float(signals.time[-1]) > _SHORTEST or self._measured(signals, joint)

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """
        Return the warming times q' and s.

        :raises DataError: if friction follows a temperature that was not recorded.
        """
        if inner['time_constant'] == 0.0:
            warm = motion.warm[:, joint]
            if not np.isfinite(warm).all():
                raise DataError(
                    'the friction of a joint follows its temperature, which the recording does '
                    'not have: record joint_temperatures'
                )
        else:
            warm = 1.0 - np.exp(-motion.time / max(inner['time_constant'], 1e-9))
        return warm * motion.v[:, joint], warm * motion.sign[:, joint]

    def units(self, signals: Recording, joint: int) -> dict[str, str]:
        """Return the units: of a drift per degC where temperature is measured."""
        units = super().units(signals, joint)
        per = '/degC' if self._measured(signals, joint) else ''
        return {**units, **{name: units[name] + per for name in self.amplitudes}}

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        if self._measured(signals, joint):
            return ({'time_constant': 0.0},)
        whole = float(signals.time[-1])
        return [{'time_constant': max(_FASTEST, whole * share)} for share in (0.4, 0.8, 1.6)]

    def inner_bounds(self, signals: Recording, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range."""
        if self._measured(signals, joint):
            return {}
        return {'time_constant': (_FASTEST, 4.0 * float(signals.time[-1]))}

    @staticmethod
    def _measured(signals: Recording, joint: int) -> bool:
        """Tell whether temperature is known throughout, and changes by more than 2 degC."""
        if signals.temperature is None:
            return False
        values = signals.temperature[:, joint]
        return bool(np.isfinite(values).all() and np.ptp(values) > 2.0)
