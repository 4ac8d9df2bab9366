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
from sosml_friction.regression.signals import Signals, Stated, bump, nominal_friction, with_rests
from sosml_friction.regression.untold_friction import with_untold_friction

#: Step of a slope over load, as a share of its root mean square: friction by load is of its first
#: or second power, and a difference to both sides is exact.
_STEP = 0.01


def with_known(
    signals: Sequence[Signals], model: RobotModelFile, like: Sequence[Signals] | None = None
) -> list[Signals]:
    """
    Return the signals with what the model has beyond the rigid body and (17) as ``known``.

    The columns of its terms times their amplitudes, seen as a diagnosis saw them that found
    them: beside the model without terms. And what its friction law has that the nominal columns
    have not, asymmetries and another exponent. ``by_load`` is the slope of those that follow load;
    ``stated`` are all that have numbers which may be off. A Stribeck term follows its level as
    bristles do, or is at it at once, whichever is nearer to the data.

    :param like: stretches that say which; None: these.
    """
    terms = known_terms(model)
    friction = model_friction(model)
    at_once = []
    for s in signals:
        known = friction.torque(s.v, s.sign) - nominal_friction(s.v, s.sign, s.scales)
        for found in terms:
            known = known + found.term.columns(s, found.joint, found.inner) @ found.amplitude
        # What was computed for the columns may depend on the nominal effort.
        at_once.append(replace(s, known=known, by_load=_slope(s, terms), cache={}))
    told = stated_terms(model)
    if like is None:
        resting = with_rests(at_once) if told else ()
        found_terms = [_as_it_follows(resting, known) for known in told]
    else:
        found_terms = [each.known for each in like[0].stated]
    stated = tuple(Stated(known, _size(signals, known)) for known in found_terms)
    result = []
    for s, before in zip(at_once, signals, strict=True):
        known = s.known + sum(
            (one.lacks(s, its) for one, its in zip(told, found_terms, strict=True)),
            start=np.zeros_like(s.q),
        )
        more = replace(s, known=known, stated=stated, cache={})
        result.append(more if stated or known.any() else before)
    return result


def _as_it_follows(signals: Sequence[Signals], known: KnownTerm) -> KnownTerm:
    """
    Return a term with the displacement over which it follows its level, if it does.

    With e what it lacks then of a term that is at its level at once, and r what is left of the
    effort, both without what bodies, Coulomb and viscous friction, a bias and the shape of a
    reversal make of them: r = c e, and c is nearer to 1 than to 0. What a joint takes at rest is
    in neither.
    """
    i = known.joint
    slow = known.following(float(signals[0].scales.displacement[i]))
    if slow is None or i in signals[0].silent:
        return known
    rows = []
    for s in signals:
        change, sign = known.lacks(s, slow)[:, i], s.sign[:, i]
        beside = [s.regressor[:, i], s.a[:, i], s.v[:, i], sign, bump(sign), np.ones(len(sign))]
        columns = np.column_stack([change, s.unexplained[:, i], *beside])
        rows.append(s.in_band(columns[:, None], [i])[:, 0])
    X = np.concatenate(rows)
    Z = X[:, 2:] / np.maximum(np.linalg.norm(X[:, 2:], axis=0), 1e-300)
    e, r = (X[:, :2] - Z @ np.linalg.lstsq(Z, X[:, :2], rcond=1e-9)[0]).T
    return slow if float(e @ r) > 0.5 * float(e @ e) > 0.0 else known


def with_all_known(
    signals: Sequence[Signals], model: RobotModelFile, settings: DiagnosisSettings
) -> list[Signals]:
    """
    Return the signals with what the model has, and the friction that it does not tell.

    What the model's own list adds to a report follows that friction, too.
    """
    known = with_known(signals, model)
    untold = with_untold_friction(known, settings)
    return with_known(untold, model, known) if untold[0].untold else known


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
