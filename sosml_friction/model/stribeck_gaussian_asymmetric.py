# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Stribeck friction that fades as a Gaussian and differs with direction."""

from __future__ import annotations

from typing import ClassVar

from sosml_friction.model.stribeck_asymmetric import StribeckAsymmetric


class StribeckGaussianAsymmetric(StribeckAsymmetric):
    """As :class:`~sosml_friction.model.stribeck_asymmetric.StribeckAsymmetric`, alpha = 2."""

    identifier: ClassVar[str] = 'stribeck_gaussian_asymmetric'
    alpha: ClassVar[float] = 2.0
