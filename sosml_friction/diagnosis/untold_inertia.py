# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Joints whose effort has nothing of the inertia that the model gives them."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.diagnosis.data_checks import Check
from sosml_friction.identification.number_text import plus_minus
from sosml_friction.model.parameter import Z_95
from sosml_friction.model.terms.inertia import Inertia
from sosml_friction.model.terms.kinds.transmission_term import TransmissionTerm
from sosml_friction.regression.chance import BEYOND_CHANCE
from sosml_friction.regression.estimate import estimate
from sosml_friction.regression.placed import Placed
from sosml_friction.regression.whitened import WhitenedRegression

#: Kind of the check.
UNTOLD = 'inertia'


def untold_joints(checks: Sequence[Check]) -> tuple[str, ...]:
    """Return the joints of which checks say so."""
    return tuple(check.joint for check in checks if check.kind == UNTOLD)


def untold_inertia(
    laboratory: WhitenedRegression, beside: Sequence[Placed] = ()
) -> dict[str, Check]:
    """
    Return the joints whose effort contradicts the inertia of the model altogether, and the check.

    Where inertia fitted freely is smaller beyond chance, and so much that the cause ``inertia`` is
    impossible, the model's is none of this motion: a wrong model, acceleration that noise and late
    stamps of position have spoiled, or a gear that gives between the two. What the model's inertia
    would need is no effort that anybody measured then, and it would hide all else.

    :param beside: causes that are fitted too: what they explain is no error of the inertia. Not
        those of a transmission, which pass on what the inertia needs: it is to be told first.
    """
    known = [each for each in beside if not isinstance(each.term, TransmissionTerm)]
    robot = laboratory.robot
    result = {}
    for i in range(robot.n):
        placed = Placed(Inertia(), i, {}, laboratory.single(Inertia(), i, {}))
        if not placed.columns.C.any():
            continue
        found = estimate(laboratory, [placed, *known])
        fitted = found.fitted(laboratory)[0]
        change, error = float(fitted.amplitude[0]), float(fitted.error[0])
        if change > -BEYOND_CHANCE * error or not Inertia().implausible(fitted):
            continue
        middle = robot.inertia(np.median(fitted.signals.q, axis=0))
        nominal = float(middle[i, i])
        seen = nominal + change
        unit = 'kg m2' if robot.effort_units[i] == 'Nm' else 'kg'
        name = robot.names[i]
        result[name] = Check(
            UNTOLD,
            'warning',
            name,
            f'the effort of {name} has an inertia of {plus_minus(seen, Z_95 * error, unit)}, '
            f'and the model {nominal:.3g}: correct its armature, record faster motion, look '
            'for play in its gear, or see whether a hand moves it; here the inertia is fitted '
            'freely',
            {'seen': seen, 'seen_std_error': error, 'model': nominal},
        )
    return result
