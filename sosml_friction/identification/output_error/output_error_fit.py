# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What output error finds of one joint."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.law.jackknife import t_95
from sosml_friction.identification.law.law_fit import LawFit
from sosml_friction.identification.law.law_form import LawForm
from sosml_friction.identification.parameter_interval import LAW_PARAMETERS
from sosml_friction.model.laws import law_definition, unit_of
from sosml_friction.model.parameter import AT_BOUND, Parameter


@dataclass(frozen=True)
class OutputErrorFit:
    """
    Hold the fit of one joint.

    ``position_error`` and ``effort_error`` [%] are 100 |simulated - measured| / |measured|; effort
    that drives the simulation has none, NaN. Both are over ``samples`` in ``clusters`` independent
    pieces; ``smoothing_velocity`` and ``exponent``, of the Stribeck term, are what was simulated.
    """

    parameters: Mapping[str, Parameter]
    position_error: float
    effort_error: float
    samples: int
    clusters: int
    smoothing_velocity: float
    exponent: float = 1.0

    def law_fit(self, effort_unit: str) -> LawFit:
        """
        Return friction as other fits hold it, without inertia.

        ``relative_error`` is of the position [%]; the residual is one of position, so that
        ``residual_std`` [Nm or N] is not known.
        """
        S = self.parameters.get('stribeck')
        knee = S is not None and np.isfinite(S.value)
        law = LawForm().identifier(self.exponent if knee else None)
        reason = 'the simulation has Coulomb and viscous friction only'
        unknown = {n: Parameter.not_told(unit_of(n, effort_unit), reason) for n in LAW_PARAMETERS}
        parameters = {n: self.parameters.get(n, x) for n, x in unknown.items()}
        if 'exponent' in law_definition(law).parameter_names:
            parameters['exponent'] = Parameter(self.exponent, '1')
        return LawFit(
            law,
            parameters,
            np.nan,
            self.position_error,
            self.samples,
            self.clusters,
            self.smoothing_velocity,
        )


def estimated(value: float, unit: str, error: float, freedom: int) -> Parameter:
    """Return a parameter with its 95 % interval; without a standard error it is at its bound."""
    half = t_95(freedom) * error
    if not np.isfinite(half):
        return Parameter(float(value), unit, float(error), None, (AT_BOUND,))
    return Parameter(float(value), unit, float(error), (float(value - half), float(value + half)))


def relative_error(simulated: FloatArray | None, measured: FloatArray) -> float:
    """Return 100 |simulated - measured| / |measured| [%], NaN where nothing was measured."""
    size = float(np.linalg.norm(measured))
    if simulated is None or not size > 0.0:
        return np.nan
    return 100.0 * float(np.linalg.norm(simulated - measured)) / size
