# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The model with what was found, and what it gains on other data."""
