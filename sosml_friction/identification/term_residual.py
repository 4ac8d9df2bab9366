# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A fitted term along its own axis: what it says beside what the data say of it."""

from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.term_fit import FittedTerm, TermFit
from sosml_friction.model.terms.kinds.term import ALL_JOINTS, TERMS
from sosml_friction.regression.noise_model import ORDER

#: Bins along the axis, of equal numbers of samples.
_BINS = 30
#: Axes with the unit of each for a revolute joint; {length} and {effort} as in a term.
UNITS = {
    'speed': '{length}/s', 'direction': '{length}/s', 'displacement': '{length}',
    'position': '{length}', 'body': '{length}', 'load': '{effort}', 'effort': '{effort}',
    'acceleration': '{length}/s2', 'time': 's', 'none': 's',
}  # fmt: skip


@dataclass(frozen=True)
class TermAxis:
    """
    Hold a term over its axis in one joint, in bins (B,).

    ``x``: mean of the axis [``unit``]; ``said``: mean effort of the term, ``seen``: the same with
    what is left of the data, and ``error`` the standard error of that mean [Nm or N].
    """

    term: FittedTerm
    joint: str
    axis: str
    unit: str
    effort_unit: str
    x: FloatArray
    said: FloatArray
    seen: FloatArray
    error: FloatArray


def along_axis(fit: TermFit, term: FittedTerm) -> list[TermAxis]:
    """Return a term over its axis, in each joint that it acts in."""
    joints = fit.names if term.joint == ALL_JOINTS else (term.joint,)
    said, left = fit.explained(term), fit.residual()
    axis = TERMS[term.term].axis
    result = []
    for name in joints:
        i = fit.names.index(name)
        x = _axis(fit, axis, i)[: len(said)]
        unit = fit.units[i]
        length = 'rad' if unit == 'Nm' else 'm'
        bins = np.array_split(np.argsort(x, kind='stable'), _BINS)
        seen = said[:, i] + left[:, i]
        result.append(
            TermAxis(
                term,
                name,
                axis,
                UNITS[axis].format(length=length, effort=unit),
                unit,
                np.array([x[b].mean() for b in bins]),
                np.array([said[b, i].mean() for b in bins]),
                np.array([seen[b].mean() for b in bins]),
                np.array([seen[b].std() / np.sqrt(len(b)) for b in bins]),
            )
        )
    return result


def _axis(fit: TermFit, axis: str, joint: int) -> FloatArray:
    """Return the axis at the rows of the band (rows,), the noise model's first ones left out."""
    parts = []
    for s in fit.laboratory.signals:
        values = {
            'speed': s.v, 'direction': s.v, 'displacement': s.v, 'position': s.q, 'body': s.q,
            'load': s.motion.load, 'effort': s.torque, 'acceleration': s.a,
        }.get(axis)  # fmt: skip
        whole = s.time if values is None else values[:, joint]
        parts.append(s.band.at_rows(whole)[ORDER:])
    return np.concatenate(parts)
