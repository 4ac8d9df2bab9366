# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort that is too late, or too early, for a small change of what the model says."""

import numpy as np

from sosml_friction.diagnosis.data_checks import Check
from sosml_friction.diagnosis.design import Design, Step
from sosml_friction.diagnosis.recordings import Recordings
from sosml_friction.identification.body_comparison import BodyComparison
from sosml_friction.identification.late_effort import LateEffort
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.parameter import Z_95
from sosml_friction.model.terms.effort_delay import EffortDelay
from sosml_friction.model.terms.kinds.term import ALL_JOINTS


def large_delay(
    design: Design, recordings: Recordings, model: RobotModelFile, step: Step
) -> LateEffort | None:
    """
    Return a delay d by which the fastest sine of the band may turn by more than a radian, or None.

    The cause ``effort_delay`` is linear in d, tau(t - d) = tau - d dtau/dt. From 2 pi f d = 1 on,
    that says nothing of the fastest f any more: the rest of the model is bent to make up for it,
    and what is left looks like a structure that nobody knows. Then effort is to be taken sooner by
    whole samples before anything is searched, as ``sosml fit`` does. Found by that column, d may
    be as large as the end of its interval.
    """
    if EffortDelay.identifier not in design.library:
        return None
    late = BodyComparison.of(recordings.logs, model, step=step, only_late=True).late
    fastest = 2.0 * np.pi * design.signals[0].band.cutoff
    if late is None or (abs(late.delay_s) + Z_95 * late.std_error) * fastest <= 1.0:
        return None
    return late


def check_of(late: LateEffort) -> Check:
    """Return what is said of it as data."""
    return Check(
        EffortDelay.identifier,
        'warning',
        ALL_JOINTS,
        late.finding().sentence,
        {'delay_s': late.delay_s, 'delay_std_error_s': late.std_error},
    )
