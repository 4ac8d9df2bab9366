# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Free curves along one axis or two: the most that any cause there could explain, and no cause."""
