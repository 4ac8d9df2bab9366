# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Fits of a friction law to pairs of velocity and friction, and what they are worth."""
