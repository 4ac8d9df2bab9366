# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Two models beside each other."""
