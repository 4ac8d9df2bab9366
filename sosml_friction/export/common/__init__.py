# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What all targets share."""
