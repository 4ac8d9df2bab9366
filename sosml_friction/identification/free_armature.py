# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Rotors of which nobody said how large they are: what the motion tells of them."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sosml_friction.identification.number_text import plus_minus
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.parameter import AT_BOUND, NOT_IDENTIFIABLE, Z_95, Parameter
from sosml_friction.regression.estimate import Estimate
from sosml_friction.regression.evidence import UNIFORM, Fit
from sosml_friction.regression.report_slopes import ReportSlopes
from sosml_friction.regression.whitened import WhitenedRegression

_FITTED = 'fitted beside friction'


def fitted_armature(
    laboratory: WhitenedRegression, found: Estimate, tolerance: float
) -> dict[str, Parameter]:
    """
    Return by joint the armature of rotors that were free: fitted inertia less that of the bodies.

    The model's bodies, so that both together are what the motion shows; its error has that of
    their inertia within the tolerance. It is at least 0, which it is flagged for where the bodies
    alone are too much, and where the motion does not tell it: where its error from the data is
    more than all inertia that the joint has. Where all of its interval is below 0 the data
    contradict the bodies, or the samples are wrong, and it is not identifiable either.
    """
    if not laboratory.settings.unknown_armature:
        return {}
    robot, nominal = laboratory.robot, laboratory.nominal
    names = nominal.names
    whole = np.diag(robot.inertia(np.median(laboratory.signals[0].q, axis=0)))
    bodies = whole - np.array(robot.armature)
    bound = found.fit.system.bound.copy()
    known = nominal.rigid_columns[np.isfinite(bound[nominal.rigid_columns])]
    bound[known] = 0.0
    x = Fit.make(replace(found.fit.system, bound=bound), laboratory.y).baseline.x
    x, errors = ReportSlopes.of(laboratory, found.placed).torque(x), found.in_torque(laboratory)[1]
    result = {}
    for i, joint in enumerate(robot.names):
        if joint not in laboratory.settings.unknown_armature:
            continue
        k = names.index(f'{joint} armature')
        value, of_data = float(robot.armature[i] + x[k]), float(errors[k])
        # The bodies' inertia is anywhere within its tolerance alike.
        error = float(np.hypot(of_data, tolerance / np.sqrt(UNIFORM) * bodies[i]))
        unit = 'kg m2' if robot.effort_units[i] == 'Nm' else 'kg'
        low, high = max(value - Z_95 * error, 0.0), max(value + Z_95 * error, 0.0)
        told = Parameter(max(value, 0.0), unit, error, (low, high), reason=_FITTED)
        if f'{joint} coulomb' not in names:
            told = replace(
                told,
                value=0.0,
                interval=(0.0, np.inf),
                flags=(NOT_IDENTIFIABLE,),
                reason='its effort is not known, so it is taken for 0',
            )
        elif not Z_95 * of_data < bodies[i] + told.value:
            told = replace(
                told,
                value=0.0,
                flags=(NOT_IDENTIFIABLE,),
                reason='the motion does not tell it, so it is taken for 0',
                experiment='record faster motion, or state it with --armature',
            )
        elif value < 0.0:
            less = f'the effort has {plus_minus(-value, Z_95 * error, unit)} less inertia '
            if value + Z_95 * error < 0.0:
                told = replace(
                    told,
                    interval=(0.0, np.inf),
                    flags=(NOT_IDENTIFIABLE,),
                    reason=f'{less}than the bodies of the URDF, which no rotor makes up for, so '
                    'it is taken for 0',
                    experiment='check the masses and lengths of the bodies, the scale of the '
                    'effort, and positions that are held or wrong',
                )
            else:
                told = replace(
                    told,
                    flags=(AT_BOUND,),
                    reason=f'{less}than the bodies of the URDF, so it is taken for 0',
                )
        result[joint] = told
    return result


def with_fitted(model: RobotModelFile, armature: Mapping[str, Parameter]) -> RobotModelFile:
    """Return the model with armatures that were fitted."""
    joints = dict(model.joints)
    for name, value in armature.items():
        joints[name] = replace(joints[name], armature=value)
    return replace(model, joints=joints)


def armature_sentence(joint: str, p: Parameter) -> str:
    """Return for a person what is known of a rotor that was fitted, without a full stop."""
    assert p.interval is not None
    text = f'The armature of {joint} was not stated and was {_FITTED}: '
    low, high = p.interval
    if p.flags:
        text += '; '.join(filter(None, (p.reason, p.experiment)))
        return f'{text} (95 % interval: 0 to {high:.3g} {p.unit})' if np.isfinite(high) else text
    return f'{text}{p.value:.4g} {p.unit} (95 % interval: {low:.3g} to {high:.3g})'
