# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The constants of the law that every simulator has, which a model may have wrong."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.recording import Recording


class LawConstant(EffortTerm):
    """State an effort whose size the model has; ``called``: its name in a sentence."""

    called: ClassVar[str]
    parameter_error: ClassVar[bool] = True
    of_law: ClassVar[bool] = True
    held_by: ClassVar[tuple[str, ...]] = ('isaaclab', 'mjcf', 'ros2-control', 'sdf', 'urdf', 'usd')
    axis: ClassVar[str] = 'speed'
    free_axis: ClassVar[str] = 'speed'
    one_power: ClassVar[bool] = True
    told_apart: ClassVar[Mapping[str, tuple[str, str]]] = {
        'thermal_drift': (
            'warm_up_repeat',
            'repeat the same speeds cold and warm: a wrong parameter is the same in both',
        )
    }

    def applies(self, signals: Recording, joint: int) -> bool:
        """Tell whether the model has one to be wrong."""
        return bool(np.isfinite(getattr(signals.scales, self.identifier)[joint]))

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if getattr(fit.signals.scales, self.identifier)[fit.joint] + fit.amplitude[0] < 0.0:
            return f'{self.called} would be negative'
        return ''
