# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""All that a report shows of one joint, in one place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.bag_analysis import BagAnalysis
from sosml_friction.identification.fitted_model import preferred_observer
from sosml_friction.identification.friction_fit import JointFit
from sosml_friction.identification.segments import Segment, SegmentSettings
from sosml_friction.model.model_folder import FrictionParameters, RobotModelFile
from sosml_friction.report.common.labels import in_order, motion_units

FloatArray = NDArray[np.float64]

#: Over what a position difference gives the velocity of figures [s], as in the fit.
WINDOW_S = 0.05


@dataclass(frozen=True)
class JointView:
    """
    Hold one joint of an analysis.

    ``time`` (N,) [s] from the first sample; ``q``, ``v``, ``tau`` (N,) as measured, NaN where not;
    ``speed`` (N,) position difference over :data:`WINDOW_S`, NaN at the ends; ``estimates`` tau_f
    (N,) per observer; ``truth`` the friction that is known to be there, None if it is not.
    """

    name: str
    effort_unit: str
    time: FloatArray
    q: FloatArray
    v: FloatArray
    tau: FloatArray
    speed: FloatArray
    estimates: Mapping[str, FloatArray]
    fits: Mapping[str, JointFit]
    alternatives: Mapping[str, JointFit]
    unavailable: str = ''
    truth: FrictionParameters | None = None
    #: The observer whose fit became the model, None if there is no fit.
    preferred: str | None = None
    #: Slower is standstill to the fits [rad/s or m/s].
    zero_band: float = SegmentSettings.zero_band

    @property
    def position_unit(self) -> str:
        """Return rad or m."""
        return motion_units(self.effort_unit)[0]

    @property
    def velocity_unit(self) -> str:
        """Return rad/s or m/s."""
        return motion_units(self.effort_unit)[1]

    @property
    def segments(self) -> tuple[Segment, ...]:
        """Return the windows of steady motion, the same for all observers."""
        fit = next(iter(self.fits.values()), None)
        return () if fit is None else fit.segments


def joint_views(analysis: BagAnalysis, truth: RobotModelFile | None = None) -> list[JointView]:
    """
    Return the joints of an analysis in the order of its model.

    :param truth: a model whose friction is known to be that of the robot, for comparison.
    :raises ConfigurationError: if ``truth`` has the friction of none of the joints.
    """
    log = analysis.log
    known = {} if truth is None else {n: j.friction for n, j in truth.joints.items() if j.friction}
    if truth is not None and not set(known) & set(log.names):
        raise ConfigurationError(
            f'the truth {truth.name} has friction for {", ".join(known) or "no joint"} where the '
            f'recording has {", ".join(log.names)}: give a model of the same joints'
        )
    units = analysis.model.make_robot().effort_units
    stated = analysis.model.provenance.get('settings', {}).get('segments', {})
    zero_band = float(stated.get('zero_band', SegmentSettings.zero_band))
    views = []
    for i, name in enumerate(log.names):
        fits = analysis.fit.joints.get(name, {})
        others = analysis.fit.alternatives.get(name, {})
        views.append(
            JointView(
                name,
                units[i],
                log.time,
                log.q[:, i],
                log.v[:, i],
                log.tau[:, i],
                position_difference(log.time, log.q[:, i]),
                {o: analysis.estimates[o][:, i] for o in in_order(analysis.estimates)},
                {o: fits[o] for o in in_order(fits)},
                {o: others[o] for o in in_order(others)},
                analysis.fit.unavailable.get(name, ''),
                known.get(name),
                preferred_observer(fits),
                zero_band,
            )
        )
    return views


def position_difference(time: FloatArray, q: FloatArray) -> FloatArray:
    """Return the centred difference of position over :data:`WINDOW_S`, (N,), NaN at the ends."""
    result = np.full(len(q), np.nan)
    step = float(np.median(np.diff(time))) if len(q) > 1 else 0.0
    half = max(1, round(0.5 * WINDOW_S / step)) if step > 0.0 else len(q)
    if len(q) > 2 * half:
        span = time[2 * half :] - time[: -2 * half]
        result[half:-half] = (q[2 * half :] - q[: -2 * half]) / np.where(span > 0.0, span, np.nan)
    return result
