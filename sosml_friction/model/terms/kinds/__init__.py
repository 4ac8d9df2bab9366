# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a term can be: effort, body, measurement, encoder, transmission; and what it is told."""
