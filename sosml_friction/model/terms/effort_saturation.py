# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A torque constant that drops at high current."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.measurement_term import MeasurementTerm
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner


class EffortSaturation(MeasurementTerm):
    """
    Add excess * (tau / tau_99)^3: measured effort exceeds the torque by ``excess`` at tau_99.

    tau_99 = ``reference`` is what 99 % of the nominal effort stay below.
    """

    identifier: ClassVar[str] = 'effort_saturation'
    amplitudes: ClassVar[Mapping[str, str]] = {'excess': '{effort}'}
    inner: ClassVar[Mapping[str, str]] = {'reference': '{effort}'}

    def excess(
        self, torque: NDArray[np.inexact], joint: int | slice, inner: Inner
    ) -> tuple[NDArray[np.inexact], ...]:
        """Return the cube of the torque in units of the reference."""
        return ((torque[..., joint] / inner['reference']) ** 3,)

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        reference = float(np.quantile(np.abs(signals.whole_torque[:, joint]), 0.99))
        return ({'reference': max(reference, 1e-9)},)

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if not 0.0 < fit.amplitude[0] < 0.5 * fit.inner['reference']:
            return 'saturation makes the effort exceed the torque, by less than half'
        return ''
