# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a model has beyond its rigid body and the nominal columns of friction, as effort."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.known_terms import KnownTerm, known_terms, model_friction
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.regression.signals import Signals, nominal_friction

#: Step of a slope over load, as a share of its root mean square: friction by load is of its first
#: or second power, and a difference to both sides is exact.
_STEP = 0.01


def with_known(signals: Sequence[Signals], model: RobotModelFile) -> list[Signals]:
    """
    Return the signals with what the model has beyond the rigid body and (17) as ``known``.

    The columns of its terms times their amplitudes, seen as a diagnosis saw them that found
    them: beside the model without terms. And what its friction law has that the nominal columns
    have not, asymmetries and another exponent. ``by_load`` is the slope of those that follow load.
    """
    terms = known_terms(model)
    friction = model_friction(model)
    result = []
    for s in signals:
        known = friction.torque(s.v, s.sign) - nominal_friction(s.v, s.sign, s.scales)
        for found in terms:
            known = known + found.term.columns(s, found.joint, found.inner) @ found.amplitude
        # What was computed for the columns may depend on the nominal effort.
        more = replace(s, known=known, by_load=_slope(s, terms), cache={})
        result.append(more if known.any() else s)
    return result


def _slope(signals: Signals, terms: Sequence[KnownTerm]) -> FloatArray | float:
    """Return by how much known friction grows with the load of its joint (N, n) [1]."""
    follows = [found for found in terms if found.term.axis == 'load']
    if not follows:
        return 0.0
    load = np.sqrt(np.mean(signals.motion.load**2, axis=0))
    step = _STEP * np.where(load > 0.0, load, 1.0)
    more, less = (
        replace(signals, more_load=signals.more_load + way * step, cache={}) for way in (0.5, -0.5)
    )
    slope = np.zeros_like(signals.q)
    for known in follows:
        up, down = (known.term.columns(s, known.joint, known.inner) for s in (more, less))
        slope += (up - down) @ known.amplitude / step
    return slope
