# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort that is too late, or too early, for a small change of what the model says."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.diagnosis.data_checks import Check
from sosml_friction.diagnosis.decision.cause import Cause
from sosml_friction.diagnosis.design import Design, Step
from sosml_friction.diagnosis.recordings import Recordings
from sosml_friction.identification.body_comparison import BodyComparison
from sosml_friction.identification.late_effort import Late
from sosml_friction.identification.shared_time import told_once
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.parameter import Z_95
from sosml_friction.model.terms.effort_delay import EffortDelay


def large_delay(design: Design, recordings: Recordings, model: RobotModelFile, step: Step) -> Late:
    """
    Return delays that are too large to be found as a small change, if any.

    The cause ``effort_delay`` is linear in d, tau(t - d) = tau - d dtau/dt. Where that is too
    coarse, d comes out too small, and from 2 pi f d = 1 on it says nothing of the fastest f of
    the band: the rest of the model is bent to make up for it, and what is left looks like a
    structure that nobody knows. Then effort is to be taken sooner by whole samples before anything
    is searched, as ``sosml fit`` does.
    """
    if EffortDelay.identifier not in design.library:
        return {}
    late = BodyComparison.of(recordings.logs, model, step=step, only_late=True).late
    large = [_may_be_large(each.delay_s, each.std_error, design) for each in late.values()]
    return late if any(large) else {}


def is_large(causes: Sequence[Cause], design: Design) -> bool:
    """Tell whether a delay was named that is too large to be found as a small change."""
    delays = [c.parameters['delay'] for c in causes if c.effect == EffortDelay.identifier]
    return any(_may_be_large(p.value, p.std_error, design) for p in delays)


def _may_be_large(delay: float, error: float, design: Design) -> bool:
    """
    Tell whether a delay d is further off by being linear in it than by its standard error.

    To the linear column a sine that comes d late is sin(w d) / w late, so that d is too small by
    up to d (w D)^2 / 6: w of the fastest of the band, D the far end of the interval of d.
    """
    turn = 2.0 * np.pi * design.signals[0].band.cutoff * (abs(delay) + Z_95 * error)
    return bool(abs(delay) * turn**2 / 6.0 > error)


def checks_of(late: Late, names: Sequence[str]) -> list[Check]:
    """
    Return what is said of them as data.

    :param names: of all joints.
    """
    return [
        Check(
            EffortDelay.identifier,
            'warning',
            joint,
            each.sentence(joint),
            {'delay_s': each.delay_s, 'delay_std_error_s': each.std_error},
        )
        for joint, each in told_once(late, names).items()
    ]
