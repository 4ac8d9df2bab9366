# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What each of several recordings says of friction, and the law that they say together."""

import math
from typing import NamedTuple

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.friction_fit import FrictionFit
from sosml_friction.identification.several.consolidation import Consolidated
from sosml_friction.model.laws import FrictionLaw, law_definition, make_friction_law

#: Bins per direction of what is not windows, equal in the logarithm of speed.
_BINS = 24
#: A bin of fewer rows is left out.
_FEWEST_IN_BIN = 3
#: Rows that are few enough to be kept one by one.
_MOST_POINTS = 200


class BagPoints(NamedTuple):
    """
    Hold what one recording says of friction: velocity, tau_f and its spread, (K,) each.

    ``spread`` is the standard deviation in the bin, 0 for a row that stands alone.
    """

    velocity: FloatArray
    friction: FloatArray
    spread: FloatArray


def bag_points(fit: FrictionFit, joint: str, observer: str) -> BagPoints | None:
    """Return the rows that a recording was fitted by, many of them as means in bins of speed."""
    rows = fit.rows.get(joint, {}).get(observer)
    if rows is None:
        return None
    keep = rows.known & (rows.mean_v != 0.0)
    v, y = rows.mean_v[keep], rows.y[keep]
    if not len(v):
        return None
    if len(v) <= _MOST_POINTS:
        return BagPoints(v, y, np.zeros(len(v)))
    speed = np.abs(v)
    edges = np.geomspace(float(np.quantile(speed, 0.01)), float(speed.max()), _BINS + 1)
    where = np.digitize(speed, edges[1:-1])
    found = []
    for way in (-1.0, 1.0):
        for k in range(_BINS):
            inside = (where == k) & (np.sign(v) == way)
            if np.sum(inside) >= _FEWEST_IN_BIN:
                found.append((np.mean(v[inside]), np.mean(y[inside]), np.std(y[inside])))
    return BagPoints(*np.array(found, dtype=float).reshape(-1, 3).T)


def own_bias(entry: Consolidated, bag: str, common: float) -> float:
    """Return the bias of a recording in the joint fit, ``common`` where it has none of its own."""
    biases = entry.agreement.own.get('bias', {})
    if not entry.own_bias or bag not in biases:
        return common
    own = biases[bag].value
    return own if math.isfinite(own) else common


def consolidated_law(entry: Consolidated) -> FrictionLaw | None:
    """Return the law of the model; without a bias where each recording has its own."""
    names = law_definition(entry.law).parameter_names
    values = {n: entry.parameters[n].value for n in names if n in entry.parameters}
    if 'bias' in values and not math.isfinite(values['bias']):
        values['bias'] = 0.0
    if len(values) < len(names) or not all(map(math.isfinite, values.values())):
        return None
    return make_friction_law(entry.law, values, entry.smoothing_velocity)
