# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What to record or change next, where causes cannot be separated."""
