# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Read the tables that other programs write, and find out what their columns are."""
