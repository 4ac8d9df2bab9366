# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a model states beyond its rigid body, Coulomb and viscous friction and bias."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.known_terms import (
    KnownTerm,
    known_terms,
    model_friction,
    stated_terms,
)
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import Signals, Stated, nominal_friction
from sosml_friction.regression.untold_friction import with_untold_friction

#: Step of a slope over load, as a share of its root mean square: friction by load is of its first
#: or second power, and a difference to both sides is exact.
_STEP = 0.01


def with_known(signals: Sequence[Signals], model: RobotModelFile) -> list[Signals]:
    """
    Return the signals with what the model has beyond the rigid body and (17) as ``known``.

    The columns of its terms times their amplitudes, seen as a diagnosis saw them that found
    them: beside the model without terms. And what its friction law has that the nominal columns
    have not, asymmetries and another exponent. ``by_load`` is the slope of those that follow load;
    ``stated`` are all that have numbers which may be off.
    """
    terms = known_terms(model)
    stated = tuple(Stated(known, _size(signals, known)) for known in stated_terms(model))
    friction = model_friction(model)
    result = []
    for s in signals:
        known = friction.torque(s.v, s.sign) - nominal_friction(s.v, s.sign, s.scales)
        for found in terms:
            known = known + found.term.columns(s, found.joint, found.inner) @ found.amplitude
        # What was computed for the columns may depend on the nominal effort.
        more = replace(s, known=known, by_load=_slope(s, terms), stated=stated, cache={})
        result.append(more if stated or known.any() else s)
    return result


def with_all_known(
    signals: Sequence[Signals], model: RobotModelFile, settings: DiagnosisSettings
) -> list[Signals]:
    """
    Return the signals with what the model has, and the friction that it does not tell.

    What the model's own list adds to a report follows that friction, too.
    """
    known = with_known(signals, model)
    untold = with_untold_friction(known, settings)
    return with_known(untold, model) if untold[0].untold else known


def _size(signals: Sequence[Signals], known: KnownTerm) -> FloatArray:
    """
    Return what the amplitudes of a term are off in proportion to, (k,).

    Each is off in proportion to itself, or to one that would need all of the term's effort, the
    larger of both: the angle of a wave and where a spring rests are as uncertain as its size. Of
    a term of nothing it is one that would need all of the joint's effort, as for C and B.
    """
    columns = [known.term.columns(s, known.joint, known.inner) for s in signals]
    most = np.max([np.abs(C).max(axis=0) for C in columns], axis=0)
    needed = np.max([np.abs(C @ known.amplitude).max(axis=0) for C in columns], axis=0)
    if not known.amplitude.any():
        needed = signals[0].scales.effort
    own = np.divide(needed[:, None], most, out=np.zeros_like(most), where=most > 0.0)
    # A term of the whole robot counts in the joint in which it needs least to do so.
    own[most == 0.0] = np.inf
    least = own.min(axis=0)
    return np.maximum(np.abs(known.amplitude), np.where(np.isfinite(least), least, 0.0))


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
