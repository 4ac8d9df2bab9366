# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From the motion of a robot and its model to friction parameters, without a file."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.block_means import block_means, block_sentence
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.source import Source, log_source
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.identification.body_comparison import BodyComparison
from sosml_friction.identification.body_refit import LOAD, BodyRefit
from sosml_friction.identification.data_checks import DataChecks, check_data
from sosml_friction.identification.data_finding import LEFT_OUT, NOTE, WARNING, DataFinding
from sosml_friction.identification.effort_timing import stated_findings, timing_findings
from sosml_friction.identification.fits_without_observer import with_output_error, with_weak_form
from sosml_friction.identification.fitted_model import (
    effects_in_law,
    fit_provenance,
    fitted_model,
    preferred_observer,
    unusable_reason,
)
from sosml_friction.identification.friction_fit import (
    WEAK_FORM,
    FitSettings,
    FrictionFit,
    fit_friction,
)
from sosml_friction.identification.inverse_model import InverseFits, fit_inverse_model
from sosml_friction.identification.joint_checks import BY_JOINT, TOO_LATE
from sosml_friction.identification.late_effort import late_findings, undone
from sosml_friction.identification.law.law_curve import fitted_law
from sosml_friction.identification.number_text import joint_text, plus_minus
from sosml_friction.identification.output_error.fits import OUTPUT_ERROR, OutputErrorFits
from sosml_friction.identification.parameter_interval import half_width
from sosml_friction.identification.regression_laws import (
    laws_of_observers,
    with_regression,
    with_regression_estimates,
    without_direction,
)
from sosml_friction.identification.repeating_effort import repeats_finding
from sosml_friction.identification.ripple import PlateauRipple, joint_ripple, shift_by_ripple
from sosml_friction.identification.weak_form import WeakForm, shown_by_slope
from sosml_friction.model.effort_correction import EffortCorrection
from sosml_friction.model.model_folder import EffectTerm, RobotModelFile
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.term import ALL_JOINTS, TERMS
from sosml_friction.observers.configuration import ObserverConfiguration
from sosml_friction.observers.log_conditions import configuration_for
from sosml_friction.plain_document import to_plain
from sosml_friction.simulation.recorded.controlled_joint import ControlledJoint


@dataclass(frozen=True)
class BagAnalysis:
    """
    Hold a fitted recording.

    ``estimates`` per observer (N, n) on the stamps of ``log``, whose joints are those of
    ``model``; ``inverse`` is None where inertia was not to be fitted. ``model`` has the inertia
    that friction was computed with: its own, or that of ``body`` where the data contradict it.
    ``ripple`` by joint is how evenly it moved on each plateau.
    """

    log: JointLog
    estimates: Mapping[str, FloatArray]
    configuration: ObserverConfiguration
    fit: FrictionFit
    model: RobotModelFile
    inverse: InverseFits | None = None
    data_checks: DataChecks | None = None
    output_error: OutputErrorFits | None = None
    body: BodyRefit | None = None
    ripple: Mapping[str, tuple[PlateauRipple, ...]] = field(default_factory=dict)

    @property
    def unmodelled(self) -> dict[str, str]:
        """Return why a joint that was fitted has no friction in the model, sentence parts."""
        return {
            name: unusable_reason(self.fit.joints[name][observer].fit.parameters)
            for name, joint in self.model.joints.items()
            if joint.friction is None
            and (observer := preferred_observer(self.fit.joints.get(name, {}))) is not None
        }


def analyse_log(
    log: JointLog,
    nominal: RobotModelFile,
    settings: FitSettings | None = None,
    bandwidth: float | None = None,
    observers: Sequence[str] | None = None,
    effort_hold: Mapping[str, str] | str | None = None,
    recorded: ObserverConfiguration | None = None,
    controllers: Callable[[JointLog], Mapping[str, ControlledJoint]] = lambda log: {},
    source: Source | None = None,
    progress: Callable[[str], None] = lambda step: None,
    require: bool = True,
    command: str = '',
    compared: BodyComparison | None = None,
) -> BagAnalysis:
    """
    Run the observers over a recording and fit friction to what they say.

    :param bandwidth: observers made by recipe with this bandwidth [rad/s] instead of ``recorded``.
    :param observers: which to run instead of ``recorded``, with gains from the noise, friction and
        motion measured in the log, or for ``bandwidth`` where that is given.
    :param effort_hold: by joint, where in an interval its effort holds; others as in ``recorded``.
        One for all joints may be given as it is.
    :param recorded: the observers that ran on line; None for those of the recipe.
    :param controllers: returns the known controllers of joints, on the stamps of a log.
    :param source: which recording this is; None for that of the samples.
    :param require: whether to refuse a recording of which no joint can be fitted alone.
    :param command: the command line that asked for it, for the provenance.
    :param compared: the comparison of several logs with the bodies, in place of that of this log.
    :raises ConfigurationError: if there is no URDF, or an observer is unknown or has no gains by
        bandwidth.
    :raises DataError: if effort is missing or the motion cannot be fitted.
    """
    source, given = source or log_source(log, 'log'), log
    settings = settings or FitSettings()
    robot = nominal.with_armature({'*': 0.0}).make_robot()
    log, checks = check_data(log, robot, source.recovery, nominal.unknown_armature)
    log, checks = _with_corrected_effort(log, checks, nominal)
    holds = effort_holds(robot.names, effort_hold or {}, recorded)
    silent = not effort_hold and not (recorded and recorded.effort_hold)
    log, together = block_means(log, () if silent else holds)
    if together > 1:
        checks = checks.told(DataFinding('means', ALL_JOINTS, NOTE, block_sentence(log, together)))
        holds = ('mean',) * len(holds)
    alone = compared is None
    exact = settings.body_tolerance == 0.0 and not nominal.unknown_armature
    if compared is None and exact and not silent:
        compared = BodyComparison()
    if compared is None:
        progress('comparing the rigid body with the motion')
        stated = bool(effort_hold)
        compared = BodyComparison.of([log], nominal, settings.body_tolerance, progress, stated)
    if compared.late:
        log = log if effort_hold else undone(compared.late, log)
        # All joints together tell it better than each by itself.
        others = [found for found in checks.findings if found.check != BY_JOINT]
        # Of effort that is later than they look for they find a part.
        too_late = any(f.check == TOO_LATE for f in others)
        told = [] if too_late else late_findings(compared.late, robot.names, bool(effort_hold))
        checks = replace(checks, findings=(*others, *told))
    body, measured = compared.refit, compared.timing
    timing = measured if silent else {}
    # One time is compared with one hold: not where joints have several, nor with means of samples.
    if not silent and not compared.late and len({*holds}) == together == 1:
        checks = checks.told(*stated_findings(measured, holds[0], log.step))
    if timing:
        holds = tuple(
            timing[joint].hold(log.step)
            if joint in timing and timing[joint].is_told(log.step)
            else hold
            for joint, hold in zip(robot.names, holds, strict=True)
        )
        if not compared.late:
            checks = checks.told(*timing_findings(timing, log.step))
    checks = checks.told(*map(repeats_finding, compared.repeats.values()))
    if body is not None:
        nominal = body.model
        robot = nominal.make_robot()
        checks = checks.told(*body.findings())
    if recorded is None or bandwidth is not None or observers is not None:
        configuration = configuration_for(log, robot, bandwidth, holds, observers)
    else:
        other = effort_hold or together > 1 or timing
        configuration = replace(recorded, effort_hold=holds) if other else recorded
    estimator = configuration.make_estimator(robot)
    progress('running the observers over the bag')
    estimates = estimator.batch(log)
    progress('fitting')
    weak_too = settings.method in ('auto', 'weak', OUTPUT_ERROR)
    fit = fit_friction(
        log,
        estimates,
        robot,
        estimator.observers,
        settings,
        require and not weak_too,
        doubt=compared.doubt,
    )
    own_holds = list(configuration.effort_hold) or 'start'
    if weak_too:
        form = WeakForm(
            log, robot, own_holds, settings, configuration.maximum_gap_s, timing, compared.doubt
        )
        fit, tau_f = with_weak_form(fit, form)
        estimates = {**estimates, WEAK_FORM: tau_f}
    if body is not None:
        own = body.variance
        fit = fit.changed(lambda joint, law: law.with_variance(own.get(joint, {})))
    loads: tuple[EffectTerm, ...] = ()
    if weak_too:
        fit, loads = with_regression(fit, compared, settings.form)
        estimates = with_regression_estimates(estimates, fit, robot.names)
        checks = checks.told(*laws_of_observers(fit)) if alone else checks
        fit = without_direction(fit, compared.loads)
    if body is not None:
        # A scale of effort that may be off, in place of masses, is in the errors.
        shift = body.shift_by_scale
        fit = fit.changed(lambda joint, law: law.with_shift(shift(joint, law)))
    # What is wrong with the data is said first. What the checks left out is told by their reason:
    # to the fit it has no effort.
    unavailable = dict(fit.unavailable)
    for name in unavailable.keys() & checks.warnings.keys():
        unavailable[name] = f'{checks.warnings[name]} ({unavailable[name]})'
    unavailable |= checks.not_fitted
    if weak_too and require and not fit.joints:
        reasons = '; '.join(f'{name}: {why}' for name, why in unavailable.items())
        raise DataError(f'no joint can be fitted. {reasons}')
    fit = replace(fit, unavailable=unavailable)
    inverse = fit_inverse_model(log, robot) if settings.refit_inertia else None
    widths = {
        name: joint.friction.smoothing_velocity if joint.friction else 0.0
        for name, joint in nominal.joints.items()
    }
    fit, output_error = with_output_error(
        fit, controllers(log), log, robot, inverse, widths, settings, own_holds
    )
    if output_error is not None and output_error.joints:
        estimates = {**estimates, OUTPUT_ERROR: np.full(log.q.shape, np.nan)}
    fit, ripple, checks = _with_ripple(log, robot, fit, checks)
    provenance = fit_provenance(source, given, configuration, fit, settings, command)
    if body is not None and body.deviations:
        earlier = nominal.provenance.get('rigid_body', {})
        provenance['rigid_body'] = {**earlier, **to_plain(body.to_dict())}
    fitted = fitted_model(nominal, fit, provenance, loads)
    checks = _with_averaged(checks, nominal, fit, fitted)
    checks = _with_loads(checks, nominal, fit, fitted, compared.loads)
    return BagAnalysis(
        log, estimates, configuration, fit, fitted, inverse, checks, output_error, body, ripple
    )


def _with_ripple(
    log: JointLog, robot: Robot, fit: FrictionFit, checks: DataChecks
) -> tuple[FrictionFit, dict[str, tuple[PlateauRipple, ...]], DataChecks]:
    """Return fits whose errors of S and v_s have the shift by hidden ripple, ripple, checks."""
    joints, found, told = dict(fit.joints), {}, []
    for i, (name, unit) in enumerate(zip(robot.names, robot.effort_units, strict=True)):
        fits = fit.joints.get(name, {})
        used = preferred_observer(fits)
        law = fits[used].fit if used else None
        rows = fit.rows.get(name, {}).get(used or '')
        smoothed = rows is not None and rows.unsmoothed is not None
        found[name], finding = joint_ripple(name, unit, log.time, log.q[:, i], law, smoothed)
        if finding is None:
            continue
        told.append(finding)
        curve = fitted_law(law) if law and not smoothed else None
        if used and law and curve:
            slopes = (partial(shown_by_slope, log.step),) if used == WEAK_FORM else ()
            shift = shift_by_ripple(found[name], curve, *slopes)
            joints[name] = {**fits, used: replace(fits[used], fit=law.with_shift(shift))}
    return replace(fit, joints=joints), found, checks.told(*told)


def effort_holds(
    names: Sequence[str], stated: Mapping[str, str] | str, recorded: ObserverConfiguration | None
) -> tuple[str, ...]:
    """
    Return where in an interval each joint's effort holds: as stated, as recorded, ``start``.

    :param stated: by joint, or one for all.
    :raises ConfigurationError: if a joint is unknown.
    """
    if isinstance(stated, str):
        return (stated,) * len(names)
    if unknown := [name for name in stated if name not in names]:
        raise ConfigurationError(
            f'effort_hold is stated for {unknown[0]!r}, which is no joint of the model: it has '
            f'{", ".join(names)}'
        )
    holds: Sequence[str] = ['start'] * len(names)
    if recorded is not None and recorded.joints == tuple(names):
        holds = recorded.effort_hold or holds
    return tuple(stated.get(name, hold) for name, hold in zip(names, holds, strict=True))


def _with_corrected_effort(
    log: JointLog, checks: DataChecks, model: RobotModelFile
) -> tuple[JointLog, DataChecks]:
    """Return the log with the torque behind its effort as far as known, and say so."""
    correction = EffortCorrection(model)
    found = [DataFinding('effects', ALL_JOINTS, LEFT_OUT, text) for text in correction.left_out]
    if correction:
        log = replace(log, tau=correction.torque(log.tau))
        sentence = f'effort was corrected by the model: {", ".join(correction.done)}'
        found.append(DataFinding('effects', ALL_JOINTS, NOTE, sentence))
    return log, checks.told(*found)


def _with_averaged(
    checks: DataChecks, nominal: RobotModelFile, fit: FrictionFit, fitted: RobotModelFile
) -> DataChecks:
    """Return the checks with what of the model's friction the law holds on average."""
    kept = {(term.effect, term.joint) for term in fitted.effects}
    # Of some the correction has told why they are left out.
    averaged = [
        term
        for term in effects_in_law(nominal)
        if (term.effect, term.joint) not in kept
        and (term.joint in fit.joints or term.joint == ALL_JOINTS)
        and term.effect in TERMS.classes
        and not TERMS[term.effect].left_out
    ]
    if not averaged:
        return checks
    names = ', '.join(f'{term.effect} of {joint_text(term.joint)}' for term in averaged)
    sentence = (
        f'the law that is fitted holds the {names} of the model on average, and the fitted model '
        'is without: --terms fits them beside a law'
    )
    return checks.told(DataFinding('effects', ALL_JOINTS, LEFT_OUT, sentence))


def _with_loads(
    checks: DataChecks,
    nominal: RobotModelFile,
    fit: FrictionFit,
    fitted: RobotModelFile,
    loads: Mapping[str, Parameter],
) -> DataChecks:
    """Return the checks with what friction by load, which no model states, does to the laws."""
    stated = {term.joint for term in (*nominal.effects, *fitted.effects) if term.effect == LOAD}
    for joint, p in loads.items():
        if joint in stated or joint not in fit.joints:
            continue
        share = plus_minus(100.0 * p.value, 100.0 * half_width(p), '%')
        what = (
            f'{share} of the load of joint {joint} is friction besides, which the law that is '
            'fitted holds on average: its Coulomb friction is that of a joint under load, and its '
            'viscous friction and what differs by direction are as far off as load goes with '
            'speed and direction; '
            f'--terms coulomb,viscous,stribeck,{LOAD} fits both'
        )
        checks = checks.told(DataFinding('load', joint, WARNING, what))
    return checks
