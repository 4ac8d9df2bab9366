# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What all reports share: paper, numbers, tables, files."""
