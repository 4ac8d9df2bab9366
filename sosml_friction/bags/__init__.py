# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Recordings: MCAP bags written, read and recovered; other bags; JointLog."""
