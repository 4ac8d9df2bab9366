# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A model written for other programs, one target in one file."""
