# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The driver of all joints: configuration, start-up, cycle, safety."""
