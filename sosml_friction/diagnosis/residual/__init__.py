# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a model leaves of the measured effort, looked at along time, position and cause."""
