# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that a model does not state: it is no cause, but whoever asks wants to know it."""

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.number_text import plus_minus
from sosml_friction.model.parameter import Z_95
from sosml_friction.model.terms.kinds.term import TERMS
from sosml_friction.regression.whitened import WhitenedRegression


def unstated_friction(
    laboratory: WhitenedRegression, x: FloatArray, errors: FloatArray
) -> list[str]:
    """
    Return the friction that the model does not state and the data show, in words, a joint each.

    :param x: all fitted parameters, the nominal ones first; ``errors``: their standard errors.
    """
    first, result = laboratory.signals[0], []
    for i, joint in enumerate(laboratory.robot.names):
        told = []
        for name in ('coulomb', 'viscous', 'bias'):
            own = f'{joint} {name}'
            if np.isfinite(getattr(first.scales, name)[i]) or own not in laboratory.nominal.names:
                continue
            k = laboratory.nominal.names.index(own)
            half = Z_95 * float(errors[k])
            if abs(x[k]) > half:
                unit = next(iter(TERMS[name]().units(first, i).values()))
                told.append(f'{name} {plus_minus(float(x[k]), half, unit)}')
        if told:
            result.append(f'{joint}: {", ".join(told)}')
    return result
