# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Trajectories, limits, followers and references: what drivers, fits and simulations share."""
