# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Free curves along one axis: what any cause there could explain at most. None is a cause."""
