# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A law fitted to pairs of velocity and friction, in one call."""

from sosml_friction.identification.law.law_search import search_law


def fit_law(v, y, clusters, effort_unit, **more):
    return search_law(v, y, clusters, **more).result(effort_unit)
