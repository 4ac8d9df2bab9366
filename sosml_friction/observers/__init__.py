# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Momentum observers: one file per observer behind one abstract base."""
