# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From a bag to friction parameters and the model folder: what the tool and the node both do."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from datetime import datetime, timezone
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.recorded_robot import RecordedRobot, read_recorded_robot
from sosml_friction.exceptions import DataError
from sosml_friction.identification.data_checks import (
    LEFT_OUT,
    NOTE,
    DataChecks,
    DataFinding,
    check_data,
)
from sosml_friction.identification.friction_fit import (
    WEAK_FORM,
    FitSettings,
    FrictionFit,
    JointFit,
    fit_friction,
)
from sosml_friction.identification.inverse_model import InverseFits, fit_inverse_model
from sosml_friction.identification.output_error.fits import (
    OUTPUT_ERROR,
    OutputErrorFits,
    closed_loop_checks,
    first_guess,
    fit_controlled,
    is_alone,
)
from sosml_friction.identification.output_error.output_error_fit import OutputErrorFit
from sosml_friction.identification.output_error.windows import fit_windows
from sosml_friction.identification.weak_form import WeakForm, WeakSettings
from sosml_friction.model.effort_correction import EffortCorrection, is_corrected
from sosml_friction.model.laws import FRICTION_LAWS
from sosml_friction.model.model_folder import (
    EffectTerm,
    FrictionParameters,
    RobotModelFile,
)
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.observers.configuration import ObserverConfiguration, parse_configuration
from sosml_friction.observers.log_conditions import configuration_for
from sosml_friction.observers.registry import OBSERVERS
from sosml_friction.simulation.recorded.controlled_joint import (
    ControlledJoint,
    recorded_controllers,
)

FloatArray = NDArray[np.float64]

#: The fit that becomes the model, where there are several: the first of these, else the first.
PREFERRED = (WEAK_FORM, 'sosml')


@dataclass(frozen=True)
class BagAnalysis:
    """
    Hold a fitted recording.

    ``estimates`` per observer (N, n) on the stamps of ``log``, whose joints are those of
    ``model``; ``inverse`` is None where inertia was not to be fitted. ``model`` keeps the inertia
    it had: friction was computed with it.
    """

    log: JointLog
    estimates: Mapping[str, FloatArray]
    configuration: ObserverConfiguration
    fit: FrictionFit
    model: RobotModelFile
    inverse: InverseFits | None = None
    data_checks: DataChecks | None = None
    output_error: OutputErrorFits | None = None

    @property
    def unmodelled(self) -> dict[str, str]:
        """Return why a joint that was fitted has no friction in the model, sentence parts."""
        return {
            name: unusable_reason(self.fit.joints[name][observer].fit.parameters)
            for name, joint in self.model.joints.items()
            if joint.friction is None
            and (observer := preferred_observer(self.fit.joints.get(name, {}))) is not None
        }


def analyse_bag(
    path: str | Path,
    model: str | Path | None = None,
    urdf: str | Path | None = None,
    settings: FitSettings | None = None,
    bandwidth: float | None = None,
    namespace: str | None = None,
    observers: Sequence[str] | None = None,
    effort_hold: Mapping[str, str] | None = None,
    progress: Callable[[str], None] = lambda step: None,
    require: bool = True,
    command: str = '',
) -> BagAnalysis:
    """
    Run the observers over a bag and fit friction to what they say.

    The bag's own robot_description, model_description and observer_configuration are used unless
    the caller gives others; a bag without observer configuration gets one by recipe.

    :param model: model folder with the armature of the joints, None for the bag's.
    :param urdf: URDF file, None for the bag's, or where it has none the model's.
    :param bandwidth: observers made by recipe with this bandwidth [rad/s] instead of the bag's.
    :param namespace: which robot, where a bag holds several.
    :param observers: which to run instead of the bag's, with gains from the noise, friction and
        motion measured in it, or for ``bandwidth`` where that is given.
    :param effort_hold: by joint, where in an interval its effort holds; others as in the bag.
    :param progress: called with each step that begins, in words.
    :param require: whether to refuse a bag of which no joint can be fitted alone.
    :param command: the command line that asked for it, for the provenance.
    :raises BagError: if the bag cannot be read or has no joint_states.
    :raises ConfigurationError: if no model or URDF is known, joints disagree, or an observer is
        unknown or has no gains by bandwidth.
    :raises DataError: if effort is missing or the motion cannot be fitted.
    """
    progress('reading the bag')
    recorded = read_recorded_robot(path, model, urdf, namespace)
    bag, nominal, robot = recorded.bag, recorded.nominal, recorded.robot
    log, checks = check_data(recorded.log, robot, bag.recovery)
    log, checks = with_corrected_effort(log, checks, nominal)
    text = bag.text('observer_configuration')
    if text is not None and bandwidth is None and observers is None:
        configuration = parse_configuration(text, f'observer_configuration of {path}')
        if effort_hold:
            holds = effort_holds(recorded, effort_hold, path)
            configuration = replace(configuration, effort_hold=holds)
    else:
        holds = effort_holds(recorded, effort_hold or {}, path)
        configuration = configuration_for(log, robot, bandwidth, holds, observers)
    estimator = configuration.make_estimator(robot)
    progress('running the observers over the bag')
    estimates = estimator.batch(log)
    progress('fitting')
    settings = settings or FitSettings()
    weak_too = settings.method in ('auto', 'weak', OUTPUT_ERROR)
    fit = fit_friction(
        log, estimates, robot, estimator.observers, settings, require and not weak_too
    )
    if weak_too:
        form = WeakForm(
            log,
            robot,
            list(configuration.effort_hold) or 'start',
            WeakSettings(
                zero_band=settings.segments.zero_band,
                refit_inertia=settings.refit_inertia,
                form=settings.form,
            ),
            configuration.maximum_gap_s,
        )
        fit, tau_f = with_weak_form(fit, form)
        estimates = {**estimates, WEAK_FORM: tau_f}
        if require and not fit.joints:
            reasons = '; '.join(f'{name}: {why}' for name, why in fit.unavailable.items())
            raise DataError(f'no joint can be fitted. {reasons}')
    fit = replace(fit, unavailable={**fit.unavailable, **checks.refused})
    inverse = fit_inverse_model(log, robot) if settings.refit_inertia else None
    widths = {
        name: joint.friction.smoothing_velocity if joint.friction else 0.0
        for name, joint in nominal.joints.items()
    }
    fit, output_error = with_output_error(
        fit, recorded_controllers(bag, log), log, robot, inverse, widths,
        settings.method == OUTPUT_ERROR, list(configuration.effort_hold) or 'start',
    )  # fmt: skip
    if output_error is not None and output_error.joints:
        estimates = {**estimates, OUTPUT_ERROR: np.full(log.q.shape, np.nan)}
    provenance = {
        **_provenance(Path(path), bag, log, configuration, fit),
        'settings': stated_settings(settings),
        'command': command,
    }
    fitted = _with_friction(nominal, fit, provenance)
    return BagAnalysis(log, estimates, configuration, fit, fitted, inverse, checks, output_error)


def with_corrected_effort(
    log: JointLog, checks: DataChecks, model: RobotModelFile
) -> tuple[JointLog, DataChecks]:
    """
    Return the log with the torque behind its effort, as far as the model knows it, and say so.

    :raises ConfigurationError: if the model's effects cannot be undone.
    """
    correction = EffortCorrection(model)
    found = [DataFinding('effects', '*', LEFT_OUT, text) for text in correction.left_out]
    if correction:
        log = replace(log, tau=correction.torque(log.tau))
        sentence = f'effort was corrected by the model: {", ".join(correction.done)}'
        found.append(DataFinding('effects', '*', NOTE, sentence))
    return log, replace(checks, findings=(*checks.findings, *found))


def with_weak_form(fit: FrictionFit, form: WeakForm) -> tuple[FrictionFit, FloatArray]:
    """
    Return the fits with those of the weak form beside them, and its means of friction (N, n).

    A joint that it cannot fit keeps what it had, with the reason under ``unavailable``; one that
    no observer could be fitted for has its fit alone.
    """
    joints = {name: dict(fits) for name, fits in fit.joints.items()}
    rows = {name: dict(its_rows) for name, its_rows in fit.rows.items()}
    unavailable = dict(fit.unavailable)
    names = form.robot.names
    tau_f = np.full((len(form.time), len(names)), np.nan)
    for i, name in enumerate(names):
        if name not in rows:
            continue
        try:
            rows[name][WEAK_FORM] = form.rows(i)
            weak = form.fit(i)
        except DataError as error:
            before = '' if name in joints else f'{unavailable[name]}; '
            unavailable[name] = f'{before}the weak form has no fit: {error}'
            continue
        if name not in joints:
            unavailable[name] = f'no observer could be fitted: {unavailable[name]}'
        segments = next((each.segments for each in joints.get(name, {}).values()), ())
        tau_f[:, i] = weak.tau_f
        joints.setdefault(name, {})[WEAK_FORM] = JointFit(
            name,
            WEAK_FORM,
            'weak',
            form.robot.effort_units[i],
            weak.fit,
            segments,
            weak.levels(segments),
            weak.inertia,
        )
    return FrictionFit(joints, fit.alternatives, unavailable, rows), tau_f


def with_output_error(
    fit: FrictionFit,
    controlled: Mapping[str, ControlledJoint],
    log: JointLog,
    robot: Robot,
    inverse: InverseFits | None,
    smoothing_velocity: Mapping[str, float],
    wanted: bool,
    effort_hold: Sequence[str] | str = 'start',
) -> tuple[FrictionFit, OutputErrorFits | None]:
    """
    Return the fits with those of output error beside them, and what simulation says of all.

    With the recorded controller where there is one, else with the measured effort, window by
    window. None where nothing was asked for.

    :param wanted: whether to fit; else only the closed loop is simulated with what ``inverse``
        found, where the controller is known.
    """
    checks = (
        {}
        if inverse is None
        else closed_loop_checks(log, robot, controlled, inverse, smoothing_velocity)
    )
    if not wanted:
        return fit, OutputErrorFits(closed_loop=checks) if checks else None
    joints = {name: dict(fits) for name, fits in fit.joints.items()}
    found: dict[str, OutputErrorFit] = {}
    modes: dict[str, str] = {}
    unavailable: dict[str, str] = {}
    for i, (name, unit) in enumerate(zip(robot.names, robot.effort_units, strict=True)):
        if name not in joints:
            unavailable[name] = fit.unavailable.get(name, 'it has no fit to begin with')
            continue
        first = next(iter(joints[name].values()))
        known = [one.fit.parameters for one in joints[name].values()]
        start = first_guess(
            robot, i, next((p for p in known if np.isfinite(p['coulomb'].value)), None)
        )
        width = smoothing_velocity[name]
        try:
            if name in controlled and is_alone(robot, log):
                modes[name] = 'controller'
                found[name] = fit_controlled(log, robot, name, controlled[name], start, width)
            else:
                modes[name] = 'measured_effort'
                found[name] = fit_windows(log, robot, i, start, width, effort_hold)
        except DataError as error:
            unavailable[name] = str(error)
            continue
        joints[name][OUTPUT_ERROR] = JointFit(
            name,
            OUTPUT_ERROR,
            OUTPUT_ERROR,
            unit,
            found[name].law_fit(unit),
            first.segments,
            np.full(len(first.segments), np.nan),
            found[name].parameters.get('inertia'),
        )
    result = OutputErrorFits(found, modes, unavailable, checks)
    return replace(fit, joints=joints), result


def effort_holds(
    recorded: RecordedRobot, stated: Mapping[str, str], path: str | Path
) -> tuple[str, ...]:
    """
    Return where in an interval each joint's effort holds: as stated, as in the bag, ``start``.

    :param path: what to call the bag in an error.
    :raises ConfigurationError: if the bag's observer_configuration cannot be read.
    """
    holds = ['start'] * recorded.robot.n
    text = recorded.bag.text('observer_configuration')
    if text is not None:
        configuration = parse_configuration(text, f'observer_configuration of {path}')
        if configuration.joints == recorded.robot.names and configuration.effort_hold:
            holds = list(configuration.effort_hold)
    return tuple(
        stated.get(name, hold) for name, hold in zip(recorded.robot.names, holds, strict=True)
    )


def preferred_observer(fits: Iterable[str]) -> str | None:
    """
    Return which of a joint's fits, by observer, becomes the model, None if there is none.

    The weak form where it was asked for, else SOSML, else the first that ran; one that carries a
    law only where there is no other.
    """
    known = list(fits)
    for name in PREFERRED:
        if name in known:
            return name
    free = [name for name in known if name in OBSERVERS and not OBSERVERS[name].carries_law]
    return next(iter(free or known), None)


def friction_of(
    law: str, parameters: Mapping[str, Parameter], smoothing_velocity: float
) -> FrictionParameters | None:
    """
    Return what a model holds of a fitted law: without Stribeck term where it is not a number.

    None where what is left is no number either: a model must not be made of it.

    :param smoothing_velocity: v0 of the sign; plateaus say nothing of it, 0 is the law as fitted.
    """
    plain = 'coulomb_viscous_asymmetric' if law.endswith('_asymmetric') else 'coulomb_viscous'
    for name in (law, plain):
        own = {key: parameters.get(key) for key in FRICTION_LAWS[name].parameter_names}
        known = {key: p for key, p in own.items() if p is not None and np.isfinite(p.value)}
        if len(known) == len(own):
            return FrictionParameters(name, smoothing_velocity, known)
    return None


def unusable_reason(parameters: Mapping[str, Parameter]) -> str:
    """Return why :func:`friction_of` has nothing, as part of a sentence."""
    for name in ('coulomb', 'viscous', 'bias'):
        p = parameters.get(name)
        if p is not None and not np.isfinite(p.value):
            reason = f'{name} is not identifiable' + (f': {p.reason}' if p.reason else '')
            return f'{reason}; {p.experiment}' if p.experiment else reason
    return 'its law has no numbers'


def stated_settings(settings: FitSettings) -> dict[str, Any]:
    """Return settings as plain values, for the provenance."""
    return asdict(settings)


def _with_friction(
    nominal: RobotModelFile, fit: FrictionFit, provenance: Mapping[str, Any]
) -> RobotModelFile:
    joints = {}
    for name, joint in nominal.joints.items():
        fits = fit.joints.get(name, {})
        observer = preferred_observer(fits)
        if observer is None:
            joints[name] = replace(joint, friction=None)
            continue
        law = fits[observer].fit
        friction = friction_of(law.law, law.parameters, law.smoothing_velocity)
        joints[name] = replace(joint, friction=friction)
    return replace(
        nominal,
        joints=joints,
        provenance={**provenance, **kept_provenance(nominal)},
        effects=kept_effects(nominal),
    )


def kept_effects(model: RobotModelFile) -> tuple[EffectTerm, ...]:
    """Return the effects that a fit leaves in a model: those of the effort it was corrected by."""
    return tuple(term for term in model.effects if is_corrected(term))


def kept_provenance(model: RobotModelFile) -> dict[str, Any]:
    """
    Return what is known of a nominal model beyond its friction, for that of a fitted one.

    The effects that the law now stands for are named: they were in the friction that was fitted.
    """
    kept = {key: model.provenance[key] for key in ('rigid_body',) if key in model.provenance}
    gone = [f'{t.effect} of {t.joint}' for t in model.effects if not is_corrected(t)]
    return {**kept, 'effects_left_out': gone} if gone else kept


def _provenance(
    path: Path, bag: Bag, log: JointLog, configuration: ObserverConfiguration, fit: FrictionFit
) -> dict[str, Any]:
    return {
        'bag': path.name,
        'sha256': bag_hash(path),
        'start_ns': int(log.t_ns[0]),
        'end_ns': int(log.t_ns[-1]),
        'samples': len(log),
        'recovered': bool(bag.recovered),
        'fitted': datetime.now(timezone.utc).isoformat(timespec='seconds'),
        'versions': {name: _version(name) for name in ('sosml_friction', 'numpy', 'scipy', 'pin')},
        'observers': {
            name: {gain: [float(x) for x in values] for gain, values in gains.items()}
            for name, gains in configuration.gains.items()
        },
        'fits': {
            joint: {observer: result.to_dict() for observer, result in fits.items()}
            for joint, fits in fit.joints.items()
        },
        'unavailable': dict(fit.unavailable),
    }


def bag_hash(path: Path) -> str:
    """Return the SHA-256 of a bag's MCAP files, in the order of their names."""
    files = sorted(path.glob('*.mcap')) if path.is_dir() else [path]
    digest = hashlib.sha256()
    for file in files:
        with file.open('rb') as stream:
            while block := stream.read(1 << 20):
                digest.update(block)
    return digest.hexdigest()


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return 'unknown'
