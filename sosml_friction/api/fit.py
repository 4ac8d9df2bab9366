# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Fit the friction of every joint to one or several recordings."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from sosml_friction.api.logs import labelled, velocity_of
from sosml_friction.api.model import Model, one_model
from sosml_friction.api.names import as_names
from sosml_friction.api.result import Result, blocks_text, interval_of
from sosml_friction.api.term_fit import Terms, fit_terms_of
from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.recorded_robot import as_recorded
from sosml_friction.bags.source import log_source, refuse_copies
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.identification.fitted_model import preferred_observer
from sosml_friction.identification.friction_fit import FitSettings
from sosml_friction.identification.law.law_form import LawForm
from sosml_friction.identification.log_analysis import BagAnalysis, analyse_log
from sosml_friction.identification.number_text import value_text
from sosml_friction.identification.several.bags_analysis import (
    BagsAnalysis,
    compare_together,
    consolidate_analyses,
)
from sosml_friction.model.parameter import Parameter
from sosml_friction.one_thread import in_one_thread
from sosml_friction.report.common.tables import summary_blocks
from sosml_friction.report.fit.findings import data_remarks, shared_sentences
from sosml_friction.report.fit.results import fit_document, write_results


class Fit(Result):
    """
    Hold the friction that was fitted.

    ``analysis`` has all details: estimates, segments, fits by every observer, data checks.
    """

    def __init__(self, analysis: BagAnalysis | BagsAnalysis) -> None:
        self.analysis = analysis

    @property
    def model(self) -> Model:
        """Return the model with the friction that was fitted."""
        return Model(self.analysis.model)

    @property
    def parameters(self) -> dict[str, dict[str, Parameter]]:
        """
        Return what is known of each parameter, by joint and name.

        One that is not identifiable has the value NaN, and the range and the reason. A joint that
        could not be fitted is not among them: :attr:`unavailable` says why. ``armature`` is among
        them where the model did not know it.
        """
        known = self.analysis
        if isinstance(known, BagsAnalysis):
            told = known.consolidation
            laws = {
                joint: told.joints[joint][observer].parameters
                for joint, observer in told.model.items()
            }
        else:
            laws = {
                joint: fits[observer].fit.parameters
                for joint, fits in known.fit.joints.items()
                if (observer := preferred_observer(fits)) is not None
            }
        one = next(iter(known.bags.values())) if isinstance(known, BagsAnalysis) else known
        rotors = {} if one.body is None else one.body.armature
        return {
            joint: {**own, **({'armature': rotors[joint]} if joint in rotors else {})}
            for joint, own in laws.items()
        }

    @property
    def unavailable(self) -> dict[str, str]:
        """Return why joints have no fit."""
        known = self.analysis
        told = known.consolidation if isinstance(known, BagsAnalysis) else known.fit
        return {name: why for name, why in told.unavailable.items() if name not in told.joints}

    def conf_int(self) -> dict[str, dict[str, tuple[float, float]]]:
        """Return 95 % intervals by joint and parameter; an end that is open is infinite."""
        return {
            joint: {name: interval_of(parameter) for name, parameter in own.items()}
            for joint, own in self.parameters.items()
        }

    def predict(self, motion: JointLog | ArrayLike) -> FloatArray:
        """
        Compute the friction torque along a motion.

        :param motion: a log that has the model's joints, or velocities (..., n) [rad/s or m/s]; of
            one joint also a number or (N,). Where a log has no velocity, it is the difference of
            position over 0.05 s.
        :return: tau_f [Nm or N], (N, n) of a log, else as ``motion``; positive for positive
            velocity, NaN where velocity or friction is not known.
        :raises ConfigurationError: if the last axis of velocities is not that of the joints.
        :raises DataError: if a joint is not in the log.
        """
        if not isinstance(motion, JointLog):
            return self.model.friction(motion)
        return self.model.friction(velocity_of(motion.select(self.model.joints)))

    def summary(self) -> str:
        """Return what was found, with its uncertainty and what the data leave open."""
        known = self.analysis
        if isinstance(known, BagsAnalysis):
            remarks = shared_sentences({bag: data_remarks(x) for bag, x in known.bags.items()})
        else:
            remarks = data_remarks(known)
        return blocks_text([*summary_blocks(known), *remarks])

    def to_dict(self) -> dict[str, Any]:
        """Return the object of ``sosml fit --json``, without its entry ``output``."""
        return fit_document(self.analysis)

    def write(self, folder: str | Path) -> Path:
        """
        Write what ``sosml fit`` writes: the model folder with report.html and fit.json.

        An earlier fit in the same place is replaced, anything else is not touched.

        :raises ConfigurationError: if the folder holds something else or cannot be written.
        """
        return write_results(folder, self.analysis)

    def _brief(self) -> str:
        parts = []
        for joint, own in self.parameters.items():
            values = [
                f'{name} {value_text(name, p)} {p.unit}'
                for name, p in own.items()
                if np.isfinite(p.value)
            ]
            parts.append(f'{joint}: {", ".join(values)}')
        parts += [f'{joint}: no fit' for joint in self.unavailable]
        return '; '.join(parts)


@in_one_thread
def fit(
    logs: JointLog | Sequence[JointLog] | Mapping[str, JointLog],
    model: Model | None = None,
    *,
    method: str = 'auto',
    law: str = 'auto',
    symmetric: bool = True,
    alpha: float | None = None,
    observers: str | Sequence[str] | None = None,
    bandwidth: float | None = None,
    effort_hold: Mapping[str, str] | str | None = None,
    refit_inertia: bool = False,
    body_tolerance: float | None = None,
    roles: Mapping[str, str] | None = None,
    own_bias: bool | None = None,
    terms: str | Sequence[str] | None = None,
    mjcf: str | Path | None = None,
) -> Fit | Terms:
    """
    Fit the friction of every joint; several recordings alone first, then together.

    :param logs: one recording, or several of one robot, by labels of their own if you like.
    :param model: rigid body and rotors; its friction is not used, effects of its effort are. An
        armature that it does not know is fitted.
    :param method: ``auto``, ``weak``, ``segments``, ``samples`` or ``output_error``; see
        :class:`~sosml_friction.identification.friction_fit.FitSettings`.
    :param law: ``auto``, ``coulomb_viscous`` or ``stribeck``.
    :param symmetric: whether friction is the same in both directions.
    :param alpha: exponent of the speed in the Stribeck term, most often 1 or 2; None for 1 unless
        the data show another.
    :param observers: see :func:`~sosml_friction.api.observe.observe`, as ``bandwidth`` and
        ``effort_hold``.
    :param refit_inertia: whether inertia is fitted too; it is reported, the model keeps its own.
    :param body_tolerance: how far each number of the rigid body may be off, as a share of itself;
        0: the model is exact; None for what the data say.
    :param roles: of several recordings, ``T1``, ``T2``, ``T3`` or ``other`` by label.
    :param own_bias: of several, whether each has a bias of its own; None for where they differ.
    :param terms: these instead of a law, by the regression that a diagnosis uses: ``coulomb``,
        ``cogging@elbow``, or a list with a name such as ``m4``. The other choices do not apply.
    :param mjcf: MuJoCo's model instead of ``model``; an armature of 0, the default there, is one
        that is not known.
    :raises ConfigurationError: if a choice is unknown, a recording is given twice, roles or
        ``own_bias`` are given for one recording, or not one of ``model`` and ``mjcf`` is given.
    :raises DataError: if effort is missing or no joint can be fitted; one sentence with reasons.
    """
    content = one_model(model, mjcf, free_rotors=True)
    if terms is not None:
        return fit_terms_of(logs, content, as_names(terms) or ())
    form = LawForm(law, symmetric, alpha)
    settings = FitSettings(
        method=method, refit_inertia=refit_inertia, form=form, body_tolerance=body_tolerance
    )
    recordings = labelled(logs)
    several = len(recordings) > 1
    if not several and (roles or own_bias is not None):
        raise ConfigurationError(
            'roles and own_bias say how several recordings are put together, and one is given: '
            'give the others too, or leave them out'
        )
    sources = {label: log_source(log, label) for label, log in recordings.items()}
    refuse_copies(sources.values())
    compared = None
    if several:
        nominal = as_recorded(content, next(iter(recordings.values())))
        compared = compare_together(recordings, nominal, settings, stated=bool(effort_hold))
    analyses = {}
    chosen = as_names(observers)
    for label, log in recordings.items():
        try:
            analyses[label] = analyse_log(
                log, as_recorded(content, log), settings, bandwidth, chosen, effort_hold,
                source=sources[label], require=not several, compared=compared,
            )  # fmt: skip
        except DataError as error:
            if not several:
                raise
            raise DataError(f'{label}: {error}') from error
    if not several:
        return Fit(next(iter(analyses.values())))
    stated = [f'{label}={role}' for label, role in (roles or {}).items()]
    return Fit(consolidate_analyses(analyses, stated, own_bias))
