# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Blind campaigns of the diagnosis and their plants: a program of its own, not tests."""
