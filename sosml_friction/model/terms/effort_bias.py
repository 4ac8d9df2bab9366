# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A constant in the measured effort."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sosml_friction.model.terms.kinds.measurement_term import MeasurementTerm
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner


class EffortBias(MeasurementTerm):
    """Add bias: an offset of the current sensor."""

    identifier: ClassVar[str] = 'effort_bias'
    amplitudes: ClassVar[Mapping[str, str]] = {'bias': '{effort}'}
    parameter_error: ClassVar[bool] = True
    aliases: ClassVar[tuple[str, ...]] = ('asymmetric_friction',)
    told_apart: ClassVar[Mapping[str, tuple[str, str]]] = {
        'asymmetric_friction': (
            'free_hanging_hold',
            'hold the joint where gravity asks nothing of it, free of load and at rest, motors '
            'off: a bias of effort stays, friction that differs between the directions does not',
        ),
        'spring': (
            'not_worn',
            'record without the person or the cable (not worn) and compare: a bias of effort '
            'stays, a spring goes',
        ),
    }

    def excess(
        self, torque: NDArray[np.inexact], joint: int | slice, inner: Inner
    ) -> tuple[NDArray[np.inexact], ...]:
        """Return 1."""
        return (np.ones_like(torque[..., joint]),)

    def applies(self, signals: Recording, joint: int) -> bool:
        """Tell whether the model knows of a bias, or of none."""
        return bool(np.isfinite(signals.scales.bias[joint]))
