# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A fitted friction law, with what its data say beside its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.identifiability import DataReach, judged
from sosml_friction.identification.law.law_checks import LawCheck
from sosml_friction.identification.law.law_profile import LawProfile
from sosml_friction.model.laws import FrictionLaw
from sosml_friction.model.parameter import Parameter

#: What a fit says beside the parameters of the law, by name in ``LawFit.derived``.
STRIBECK_AT_SLOWEST = 'stribeck_at_slowest'
DERIVED = {
    STRIBECK_AT_SLOWEST: 'extra friction S exp(-w / v_s) at the slowest speed w of the data',
    'coulomb_positive': 'Coulomb friction forwards, C + bias',
    'coulomb_negative': 'Coulomb friction backwards, C - bias',
    'viscous_positive': 'viscous friction forwards, B + its asymmetry',
    'viscous_negative': 'viscous friction backwards, B - its asymmetry',
    'stribeck_positive': 'extra friction near standstill forwards, S + its asymmetry',
    'stribeck_negative': 'extra friction near standstill backwards, S - its asymmetry',
}


@dataclass(frozen=True)
class LawFit:
    """
    Hold a fitted law.

    ``law`` is the name of the law whose parameters the data give: with its Stribeck term only
    where S and v_s are identifiable. A parameter that is not is NaN with an interval, its end
    infinite where it is open. ``drawn`` are the numbers of the best fit, flagged or not, of the
    law ``drawn_law``: to draw the curve within the speeds of the data, and for nothing else.

    ``residual_std`` [Nm or N] and ``relative_error`` [%] = 100 |y - law| / |y| are over the pairs
    fitted. ``smoothing_velocity`` [rad/s or m/s] is that of the sign, as it was given or found, 0
    for the sign itself. ``derived`` is what the data tell beside the parameters, by the names in
    ``DERIVED``; ``checks`` say whether the law is friction at all. ``covariance`` (P, P) is that
    of the estimates of ``covariance_of``, in their units, if none of ``others`` is true: laws that
    may be, each with its probability. What they move is in the errors of the parameters.
    ``profile`` is None without a Stribeck term; ``slowest`` [rad/s or m/s] is the least speed of
    the data, ``extra`` the factors of the columns that the caller added. ``reach``: what the data
    cover, by which a parameter is identifiable or not; None where that is not judged.
    ``freedom``: degrees of freedom of the covariance, None for those that the clusters leave.
    """

    law: str
    parameters: Mapping[str, Parameter]
    residual_std: float
    relative_error: float
    pairs: int
    clusters: int
    smoothing_velocity: float = 0.0
    derived: Mapping[str, Parameter] = field(default_factory=dict)
    checks: tuple[LawCheck, ...] = ()
    drawn: Mapping[str, float] = field(default_factory=dict)
    drawn_law: str = ''
    covariance: FloatArray | None = None
    covariance_of: tuple[str, ...] = ()
    profile: LawProfile | None = None
    slowest: float = float('nan')
    extra: tuple[Parameter, ...] = ()
    others: tuple[tuple[FrictionLaw, float], ...] = field(default=(), repr=False)
    reach: DataReach | None = None
    freedom: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return what is said of every law that was fitted."""
        return {
            'law': self.law,
            'parameters': self.parameters,
            'derived': self.derived,
            'checks': self.checks,
            'relative_error': self.relative_error,
            'residual_std': self.residual_std,
            'pairs': self.pairs,
            'clusters': self.clusters,
        }

    def with_variance(self, variance: Mapping[str, float]) -> LawFit:
        """Return the fit with a variance added to parameters, that its rows do not show."""
        parameters = dict(self.parameters)
        covariance = None if self.covariance is None else self.covariance.copy()
        for name, more in variance.items():
            if name in parameters:
                wide = parameters[name].with_variance(more)
                parameters[name] = judged(name, wide, self.reach)
            if covariance is not None and name in self.covariance_of:
                k = self.covariance_of.index(name)
                covariance[k, k] += more
        return replace(self, parameters=parameters, covariance=covariance)

    def with_shift(self, shift: Mapping[str, float]) -> LawFit:
        """Return the fit with an error of one cause added, that moves all parameters together."""
        fit = self.with_variance({name: by**2 for name, by in shift.items()})
        if fit.covariance is None:
            return fit
        d = np.array([shift.get(name, 0.0) for name in fit.covariance_of])
        # The variances are in it already.
        return replace(fit, covariance=fit.covariance + np.outer(d, d) - np.diag(d**2))
