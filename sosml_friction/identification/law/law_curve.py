# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A fitted law as a curve: what it says at a velocity, and how sure that is."""

import math

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.law.jackknife import t_95
from sosml_friction.identification.law.law_fit import LawFit
from sosml_friction.model.laws import FrictionLaw, law_definition, make_friction_law

#: Step of the differences that make the gradient of the law, as a share of a parameter.
_STEP = 1e-5


def fitted_law(fit: LawFit) -> FrictionLaw | None:
    """
    Return the law that a fit found, its sign as the fit took it; None where it has no numbers.

    A law whose parameters cannot all be told is that of the best fit: within the speeds of the
    data it is known, though its parameters are not. It is for curves and residuals.
    """
    name = fit.drawn_law or fit.law
    values = {
        key: fit.drawn.get(key, fit.parameters[key].value if key in fit.parameters else math.nan)
        for key in law_definition(name).parameter_names
    }
    if not all(map(math.isfinite, values.values())):
        return None
    return make_friction_law(name, values, fit.smoothing_velocity)


def band(fit: LawFit, v: FloatArray) -> FloatArray | None:
    """
    Return half of the 95 % confidence band of the fitted law at each velocity, (N,) [Nm or N].

    The band of the mean at one velocity, t sqrt(g' Cov g + sum p d^2) with the gradient g of the
    law, d how far another law of probability p is from it there, and Student's t for the fit's
    degrees of freedom; None where the fit has no covariance.

    :param v: velocity (N,) [rad/s or m/s].
    """
    law, covariance, names = fitted_law(fit), fit.covariance, fit.covariance_of
    if law is None or covariance is None or not set(names) <= set(law.parameters):
        return None
    if not np.isfinite(covariance).all():
        return None
    gradient = np.empty((len(v), len(names)))
    for k, name in enumerate(names):
        value = law.parameters[name]
        step = _STEP * (abs(value) or 1.0)
        ends = [
            make_friction_law(
                law.identifier,
                {**law.parameters, name: value + way * step},
                law.smoothing_velocity,
            ).torque(v)
            for way in (-1.0, 1.0)
        ]
        gradient[:, k] = (ends[1] - ends[0]) / (2.0 * step)
    variance = np.einsum('ni,ij,nj->n', gradient, covariance, gradient)
    for other, probability in fit.others:
        variance += probability * (other.torque(v) - law.torque(v)) ** 2
    freedom = fit.freedom or max(fit.clusters - len(names), 1)
    return np.array(t_95(freedom) * np.sqrt(np.maximum(variance, 0.0)))


def largest_friction(fit: LawFit, speed: float) -> float | None:
    """
    Return how large friction may be at a speed, (f(w) - f(-w)) / 2 and its band [Nm or N].

    What does not change with direction is none. None where the law has no band.
    """
    v = np.array([speed, -speed])
    law, half = fitted_law(fit), band(fit, v)
    if law is None or half is None:
        return None
    forwards, backwards = law.torque(v)
    return float(0.5 * (forwards - backwards) + half.max())
