# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The registry of friction laws."""

from __future__ import annotations

from collections.abc import Mapping

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.coulomb_viscous import CoulombViscous
from sosml_friction.model.coulomb_viscous_asymmetric import CoulombViscousAsymmetric
from sosml_friction.model.friction_law import FrictionLaw
from sosml_friction.model.stribeck import Stribeck
from sosml_friction.model.stribeck_asymmetric import StribeckAsymmetric
from sosml_friction.model.stribeck_gaussian import StribeckGaussian
from sosml_friction.model.stribeck_gaussian_asymmetric import StribeckGaussianAsymmetric

FRICTION_LAWS: dict[str, type[FrictionLaw]] = {
    law.identifier: law
    for law in (
        CoulombViscous,
        Stribeck,
        StribeckGaussian,
        CoulombViscousAsymmetric,
        StribeckAsymmetric,
        StribeckGaussianAsymmetric,
    )
}


def make_friction_law(
    identifier: str, parameters: Mapping[str, float], smoothing_velocity: float
) -> FrictionLaw:
    """
    Build a friction law from its name in a model file.

    :raises ConfigurationError: if no law has that name; the sentence lists those that exist.
    """
    if identifier not in FRICTION_LAWS:
        raise ConfigurationError(
            f'friction law {identifier!r} is unknown: use one of {", ".join(FRICTION_LAWS)}'
        )
    return FRICTION_LAWS[identifier](parameters, smoothing_velocity)
