# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Output error: simulate, compare with the measured motion, adjust."""
