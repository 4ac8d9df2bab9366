# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Stribeck friction that fades as a Gaussian, equation (10) of the paper with alpha = 2."""

from __future__ import annotations

from typing import ClassVar

from sosml_friction.model.stribeck import Stribeck


class StribeckGaussian(Stribeck):
    """tau_f = s(v) (C + S exp(-(v / v_s)^2)) + B v + bias."""

    identifier: ClassVar[str] = 'stribeck_gaussian'
    alpha: ClassVar[float] = 2.0
