# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One joint of an analysis, as tables and figures show it."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.body_refit import LOAD
from sosml_friction.identification.fitted_model import preferred_observer
from sosml_friction.identification.friction_fit import JointFit
from sosml_friction.identification.law_residual import Residual, law_residual, position_difference
from sosml_friction.identification.log_analysis import BagAnalysis
from sosml_friction.identification.ripple import PlateauRipple
from sosml_friction.identification.segments import Segment, SegmentSettings
from sosml_friction.model.model_folder import FrictionParameters, RobotModelFile
from sosml_friction.model.parameter import Parameter
from sosml_friction.report.common.drawing import Style, style_of
from sosml_friction.report.common.labels import in_order, motion_units

#: More estimates than this over one another cannot be told apart.
_MOST_LINES = 4


@dataclass(frozen=True)
class JointView:
    """
    Hold one joint of an analysis.

    ``time`` (N,) [s] from the first sample; ``q``, ``v``, ``tau`` (N,) as measured, NaN where not;
    ``speed`` (N,) position difference, NaN at the ends; ``estimates`` tau_f (N,) per observer;
    ``truth`` the friction that is known to be there, None if it is not; ``preferred`` the observer
    whose fit became the model, None if there is no fit; ``zero_band`` what is standstill to the
    fits [rad/s or m/s]; ``ripple`` how evenly it moved on each plateau.
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
    preferred: str | None = None
    zero_band: float = SegmentSettings.zero_band
    load: Parameter | None = None
    ripple: tuple[PlateauRipple, ...] = ()

    @property
    def position_unit(self) -> str:
        """Return rad or m."""
        return motion_units(self.effort_unit)[0]

    @property
    def velocity_unit(self) -> str:
        """Return rad/s or m/s."""
        return motion_units(self.effort_unit)[1]

    @property
    def fastest(self) -> float:
        """Return where an axis of velocity ends: a little beyond the fastest speed."""
        return 1.05 * (float(np.max(np.abs(np.nan_to_num(self.speed)), initial=0.0)) or 1.0)

    @property
    def segments(self) -> tuple[Segment, ...]:
        """Return the windows of steady motion, the same for all observers."""
        fit = next(iter(self.fits.values()), None)
        return () if fit is None else fit.segments

    @property
    def known(self) -> Mapping[str, Parameter]:
        """Return the parameters of the truth, empty where it is not known."""
        return {} if self.truth is None else self.truth.parameters

    @property
    def model(self) -> JointFit | None:
        """Return the fit that became the model."""
        return None if self.preferred is None else self.fits[self.preferred]

    def style(self, observer: str) -> Style:
        """Return how an observer is drawn in every figure of this joint."""
        return style_of(observer, list(self.estimates).index(observer))

    def residual(self) -> Residual | None:
        """Return what the law of the model leaves, None where there is nothing."""
        if self.model is None or self.preferred is None:
            return None
        tau_f = self.estimates[self.preferred]
        found = law_residual(self.model, tau_f, self.speed, self.zero_band)
        return None if found is None or not len(found.samples) else found


def joint_views(analysis: BagAnalysis, truth: RobotModelFile | None = None) -> list[JointView]:
    """
    Return the joints of an analysis in the order of its model.

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
    fitted = (term for term in analysis.model.effects if term.effect == LOAD)
    loads = {term.joint: term.parameters['load_coefficient'] for term in fitted}
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
                loads.get(name),
                analysis.ripple.get(name, ()),
            )
        )
    return views


def shown_estimates(view: JointView) -> list[str]:
    """Return which estimates a figure shows over one another: the model's and the first others."""
    first = [] if view.preferred is None else [view.preferred]
    others = [name for name in view.estimates if name not in first]
    chosen = {*first, *others[: _MOST_LINES - len(first)]}
    return [name for name in view.estimates if name in chosen]
