# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Causes that the data show by themselves: faults of data, impacts of teeth, contacts."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.diagnosis.data_checks import Check
from sosml_friction.diagnosis.decision.cause import FAULTS, Cause
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.model.parameter import Z_95, Parameter
from sosml_friction.model.terms.effort_delay import EffortDelay
from sosml_friction.model.terms.kinds.term import TERMS
from sosml_friction.regression.chance import NEGLIGIBLE
from sosml_friction.regression.contacts import Impacts
from sosml_friction.regression.whitened import WhitenedRegression

#: Contacts of a joint whose begin and end are reported.
_MOST_EPISODES = 20
_NO_EVIDENCE: dict[str, float | None] = dict.fromkeys(('delta_bic', 'cv_gain', 'cv_gain_se'))


def data_causes(
    checks: Sequence[Check],
    laboratory: WhitenedRegression,
    without: tuple[str, ...],
    selection: Selection,
) -> list[Cause]:
    """Return the causes that no column of a candidate shows, but for those of ``without``."""
    impacts = () if 'backlash' in without else laboratory.contacts.impacts
    causes = [
        *_faults(checks),
        *(_backlash(laboratory, selection, x, without) for x in impacts),
        *_contacts(laboratory),
    ]
    return [cause for cause in causes if cause.effect not in without]


def _faults(checks: Sequence[Check]) -> list[Cause]:
    causes = []
    for check in checks:
        if check.severity == 'warning' and check.kind in FAULTS:
            parameters = {
                name: Parameter(value, 's' if name.endswith('_s') else '1')
                for name, value in check.values.items()
            }
            if check.kind == EffortDelay.identifier:
                # As where a column of it is fitted.
                delay, error = check.values.values()
                parameters = {'delay': Parameter.estimated(delay, 's', error, Z_95)}
            causes.append(Cause(check.kind, check.joint, parameters, _NO_EVIDENCE))
    return causes


def _backlash(
    laboratory: WhitenedRegression,
    selection: Selection,
    impacts: Impacts,
    without: tuple[str, ...],
) -> Cause:
    parameters = {
        **_gap(laboratory, selection, impacts.joint),
        'load_changes': Parameter(float(impacts.changes), '1'),
        'impact_share': Parameter(impacts.share, '1'),
        'impact_ratio': Parameter(impacts.ratio, '1'),
    }
    rivals = () if 'joint_elasticity' in without else ('joint_elasticity',)
    name = laboratory.robot.names[impacts.joint]
    return Cause('backlash', name, parameters, _NO_EVIDENCE, rivals)


def _gap(laboratory: WhitenedRegression, selection: Selection, joint: int) -> dict[str, Parameter]:
    """
    Return gap and stiffness of the gear that leaves least of the impacts.

    Their waveform is hardly predicted, so that both are rough, have no standard errors, and are
    not for the model: a simulation with them goes more astray than one without.
    """
    effect, first = TERMS['backlash'](), laboratory.signals[0]
    y, Z = laboratory.unwhitened()
    left = y - Z @ selection.after.x[: Z.shape[2]]
    rows = laboratory.contacts.mask[:, joint]
    size = np.maximum(np.std(left[~rows], axis=0), 1e-300)
    grid = effect.grid(first, joint)
    energies = [
        float(
            (((left - laboratory.own_columns(effect, joint, inner)[:, :, 0])[rows] / size) ** 2)
            .sum()
        )
        for inner in grid
    ]  # fmt: skip
    inner = grid[int(np.argmin(energies))]
    units = effect.units(first, joint)
    return {name: Parameter(float(inner[name]), units[name]) for name in effect.inner}


def _contacts(laboratory: WhitenedRegression) -> list[Cause]:
    causes = []
    for i, name in enumerate(laboratory.robot.names):
        episodes = [e for e in laboratory.contacts.contacts if e.joint == i]
        share = sum(e.energy for e in episodes) / max(float(laboratory.noise_energy[i]), 1.0)
        if not episodes or share < NEGLIGIBLE:
            continue
        parameters = {'episodes': Parameter(float(len(episodes)), '1')}
        level = episodes[0].level
        if np.isfinite(level):
            parameters['level'] = Parameter(level, laboratory.robot.effort_units[i])
            # A push may be on for most of the time: what is judged is the rest.
            left_out = float(laboratory.contacts.mask[:, i].mean())
            parameters['share_left_out'] = Parameter(left_out, '1')
        for k, e in enumerate(episodes[:_MOST_EPISODES], 1):
            parameters[f'start_{k}'] = Parameter(e.start_s, 's')
            parameters[f'end_{k}'] = Parameter(e.end_s, 's')
        causes.append(Cause('external_contact', name, parameters, _NO_EVIDENCE))
    return causes
