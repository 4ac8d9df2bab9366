# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Trajectories, segments and fits: from measured motion to friction parameters."""
