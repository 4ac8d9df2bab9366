# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Figures of the report of fitted terms."""
