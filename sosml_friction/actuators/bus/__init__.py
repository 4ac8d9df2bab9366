# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The bus: frames, adapters, one exchange in each cycle, who answers."""
