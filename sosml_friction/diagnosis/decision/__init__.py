# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which causes the rows speak for: candidates, gates, rivals, verdict."""
