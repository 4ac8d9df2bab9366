# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A law fitted to pairs of velocity and friction, in one call."""

from sosml_friction.identification.law.law_search import search_law
from sosml_friction.identification.law.law_summary import LawSummary

#: Friction of the emulated shoulder, with a bias.
TRUTH = {
    'coulomb': 0.8,
    'viscous': 0.35,
    'stribeck': 0.5,
    'stribeck_velocity': 0.03,
    'bias': 0.1,
}


def fit_law(v, y, clusters, effort_unit, **more):
    return LawSummary(search_law(v, y, clusters, **more), effort_unit).fit()
