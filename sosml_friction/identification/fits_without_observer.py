# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The fits that need no observer, beside those of the observers: weak form and output error."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TypeVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import DataError, MotionError
from sosml_friction.identification.friction_fit import (
    WEAK_FORM,
    FitSettings,
    FrictionFit,
    JointFit,
)
from sosml_friction.identification.inverse_model import InverseFits
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
from sosml_friction.identification.weak_form import WeakForm
from sosml_friction.model.robot import Robot
from sosml_friction.simulation.recorded.controlled_joint import ControlledJoint

_Found = TypeVar('_Found')


def with_weak_form(fit: FrictionFit, form: WeakForm) -> tuple[FrictionFit, FloatArray]:
    """
    Return the fits with those of the weak form beside them, and its means of friction (N, n).

    A joint that it cannot fit keeps what it had, with the reason under ``unavailable``; one that
    no observer could be fitted for has its fit alone, one whose motion cannot tell a law has none.
    """
    joints = {name: dict(fits) for name, fits in fit.joints.items()}
    rows = {name: dict(its_rows) for name, its_rows in fit.rows.items()}
    unavailable = dict(fit.unavailable)
    names = form.robot.names
    tau_f = np.full((len(form.time), len(names)), np.nan)
    wanted = [i for i, name in enumerate(names) if name in rows]
    # The laws of the first velocities are those that the second are smoothed by.
    first, _ = _each(form.law, wanted)
    form = form.with_laws([first.get(i) for i in range(len(names))])
    second, _ = _each(form.law, wanted)
    form = form.with_memory([second.get(i) for i in range(len(names))])
    found, failed = _each(form.fit, wanted)
    for i in wanted:
        name = names[i]
        with suppress(DataError):
            rows[name][WEAK_FORM] = form.rows(i)
        if isinstance(failed.get(i), MotionError):
            # An observer sees more speeds where the joint turns around, late and smoothed.
            joints.pop(name, None)
            unavailable[name] = str(failed[i])
            continue
        if i in failed:
            before = '' if name in joints else f'{unavailable[name]}; '
            unavailable[name] = f'{before}the weak form has no fit: {failed[i]}'
            continue
        weak = found[i]
        if name not in joints:
            unavailable[name] = f'no observer could be fitted: {unavailable[name]}'
        segments = next((each.segments for each in joints.get(name, {}).values()), ())
        tau_f[:, i] = weak.tau_f
        joints.setdefault(name, {})[WEAK_FORM] = JointFit(
            WEAK_FORM,
            'weak',
            form.robot.effort_units[i],
            weak.fit,
            segments,
            weak.levels(segments),
            weak.inertia,
        )
    return FrictionFit(joints, fit.alternatives, unavailable, rows), tau_f


def _each(
    fit: Callable[[int], _Found], joints: Sequence[int]
) -> tuple[dict[int, _Found], dict[int, DataError]]:
    """Return what was fitted by joint, and why others have nothing."""
    found, failed = {}, {}
    for i in joints:
        try:
            found[i] = fit(i)
        except DataError as error:
            failed[i] = error
    return found, failed


def with_output_error(
    fit: FrictionFit,
    controlled: Mapping[str, ControlledJoint],
    log: JointLog,
    robot: Robot,
    inverse: InverseFits | None,
    smoothing_velocity: Mapping[str, float],
    settings: FitSettings,
    effort_hold: Sequence[str] | str,
) -> tuple[FrictionFit, OutputErrorFits | None]:
    """
    Return the fits with those of output error beside them, and what simulation says of all.

    With the recorded controller where there is one, else with the measured effort, window by
    window. By another method only the closed loop is simulated with what ``inverse`` found, where
    the controller is known; None where it is not.
    """
    checks = (
        {}
        if inverse is None
        else closed_loop_checks(log, robot, controlled, inverse, smoothing_velocity)
    )
    if settings.method != OUTPUT_ERROR:
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
        laws = list(joints[name].values())
        known = [one.fit.parameters for one in laws]
        start = first_guess(
            robot, i, next((p for p in known if np.isfinite(p['coulomb'].value)), None)
        )
        width = smoothing_velocity[name]
        found_exponents = (x.fit.drawn['exponent'] for x in laws if 'exponent' in x.fit.drawn)
        exponent = next(found_exponents, settings.form.usual)
        try:
            if name in controlled and is_alone(robot, log):
                modes[name] = 'controller'
                found[name] = fit_controlled(log, robot, name, controlled[name], start, width)
            else:
                modes[name] = 'measured_effort'
                found[name] = fit_windows(log, robot, i, start, width, effort_hold, exponent)
        except DataError as error:
            unavailable[name] = str(error)
            continue
        joints[name][OUTPUT_ERROR] = JointFit(
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
